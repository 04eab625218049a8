"""Result: the result of a simulation, in memory and as a file.

World z-up, metres, seconds, newton seconds; quaternions wxyz; T frames at `Result.fps`.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import array_of
from halfphysics.base.copying import FrozenMapping, ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.base.short_repr import counted
from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.deferred import Deferred, typed, typed_or_deferred
from halfphysics.results.held import HeldReport, held
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.naming import Naming
from halfphysics.results.object_track import ObjectTrack as ObjectTrack
from halfphysics.results.person_result import PersonResult as PersonResult
from halfphysics.results.simulated_scene import SimulatedScene
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.results.substeps import Substeps
from halfphysics.results.surroundings import Surroundings
from halfphysics.settings import Settings

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from halfphysics.body.body import Body
    from halfphysics.metrics.part_report import PartReport
    from halfphysics.results.dents import Dent
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Time after a contact until the body is on its reference again: a deviation of 2 rad returns in
#: 0.25 s at the default `Settings.recovery_rate`, then twelve time constants of the drive [s].
SETTLE = 0.5


#: Diagnostics of a frame: contact planes and points (largest number in any substep), solves, their
#: sweeps and steps, substeps that were shortened, and the largest residuals of a substep: of gaps
#: at its end [m], of Coulomb friction [m/s], and that in multiples of `Settings.tolerance`.
DIAGNOSTICS = (
    *("planes", "contacts", "passes", "sweeps", "shortened", "residual"),
    *("friction_residual", "friction_tolerances"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Result(InNotebook, ReadOnly):
    """The result of `simulate`.

    Attributes:
        people: One entry per person.
        objects: Name -> `ObjectTrack` of T frames.
        scene: The simulated scene. In a result from a file it is loaded on first access; items
            whose mesh file is missing are left out, with a warning.
        names: Names to which `contacts` refers: statics, objects, people, in this order.
        contacts: The contacts, in every frame by pair of shapes and direction.
        clearance: Minimum distance of the people from the statics in every frame (T,) [m]; inf
            beyond `Settings.clearance_range`, negative: penetration.
        lost_time: Time by which blocked steps were shortened, per frame (T,) [s].
        settings: Settings of the simulation.
        substeps: Every committed pose, with ``Settings(record="substeps")``, else None.
        diagnostics: Name -> number of every frame (T,), see `DIAGNOSTICS`; empty where unknown.
        joints: "NAME/JOINT" of an articulated object -> its value of every frame (T,) [rad or m],
            quaternions (T, 4) of a ball joint, position [m] and quaternion (T, 7) of a free joint.
            Links are among the `objects`: "NAME/LINK".
        inside: Overlaps of parts with statics or objects, and of objects with statics, with their
            depths; empty if there was none at the start.
        breaches: Overlaps of bodies that were clear before, found by a check of every committed
            pose: empty unless the promise that they stay clear was broken.
        soft_contacts: The pressures on what is soft; None where nothing is.

    Raises:
        InputError: Inconsistent parts, or parts of a wrong type.
    """

    people: tuple[PersonResult, ...]
    objects: Mapping[str, ObjectTrack]
    scene: Deferred[Scene] = Deferred()
    names: tuple[str, ...]
    contacts: Contacts
    clearance: Array
    lost_time: Array
    settings: Settings
    substeps: Substeps | None = None
    diagnostics: Mapping[str, Array] = field(default_factory=dict)
    inside: Inside = field(default_factory=Inside.none)
    breaches: Breaches = field(default_factory=Breaches.none)
    joints: Mapping[str, Array] = field(default_factory=dict)
    soft_contacts: SoftContacts | None = None

    def __post_init__(self) -> None:
        from halfphysics.scene.scene import Scene

        _set(self, "people", tuple(self.people))
        for index, person in enumerate(self.people):
            typed(f"people[{index}]", person, PersonResult)
        scene = vars(self)["_scene"]
        typed_or_deferred("scene", scene, Scene)
        if isinstance(scene, Scene):  # its owner may go on building
            _set(self, "scene", SimulatedScene(scene, scene._copied()))
        typed("contacts", self.contacts, Contacts)
        typed("inside", self.inside, Inside)
        typed("breaches", self.breaches, Breaches)
        typed("settings", self.settings, Settings)
        if self.soft_contacts is not None:
            typed("soft_contacts", self.soft_contacts, SoftContacts)
        _set(self, "names", tuple(self.names))
        _set(self, "objects", FrozenMapping(dict(self.objects)))
        if not self.people:
            raise InputError("people: found none, expected at least one")
        self._check_lengths()
        expected = [*self.objects, *(p.name for p in self.people)]
        if list(self.names[len(self.names) - len(expected) :]) != expected:
            raise InputError(
                f"names: found {', '.join(self.names)}; expected statics, then {expected}"
            )
        limits = {
            "frame": (0, len(self)),
            "person": (-1, len(self.people)),
            "part": (-1, N_JOINTS),
            "other": (0, len(self.names)),
            "subject": (-1, len(self.names)),
            "other_part": (-1, N_JOINTS),
            "layer": (0, len(self.names)),
            "vertex": (-1, 2**31),
        }
        naming = Naming(self.names, len(self.people), self.fps)
        for name in ("contacts", "inside", "breaches", "soft_contacts"):
            if (table := getattr(self, name)) is not None:
                table.check_within(limits)
                _set(self, name, table.named(naming))
        _set(self, "people", tuple(self._settled(index) for index in range(len(self.people))))

    def _settled(self, index: int) -> PersonResult:
        """A person of this result, who knows what is around."""
        around = Surroundings(
            scene=vars(self)["_scene"],
            tracks=self.objects,
            names=self.names,
            contacts=self.contacts,
            person=index,
            people=len(self.people),
        )
        person = self.people[index]
        return dataclasses.replace(person, body=vars(person)["_body"], surroundings=around)

    def _check_lengths(self) -> None:
        """Copy the arrays, read-only; each has one row per frame."""
        frames = len(self)
        lengths = {f"people[{i}]": len(p.motion) for i, p in enumerate(self.people)}
        lengths |= {f"objects[{name!r}]": len(track) for name, track in self.objects.items()}
        for name in ("clearance", "lost_time"):
            array = np.array(array_of(getattr(self, name)), dtype=np.float64)
            if array.ndim != 1 or np.isnan(array).any():
                raise InputError(
                    f"{name}: found shape {array.shape} with {int(np.isnan(array).sum())} NaN, "
                    f"expected numbers of shape ({frames},)"
                )
            array.setflags(write=False)
            _set(self, name, array)
            lengths[name] = len(array)
        for field_name in ("diagnostics", "joints"):
            arrays = {}
            for name, given in getattr(self, field_name).items():
                arrays[name] = np.array(array_of(given), dtype=np.float64)
                arrays[name].setflags(write=False)
                lengths[f"{field_name}[{name!r}]"] = len(np.atleast_1d(arrays[name]))
            _set(self, field_name, FrozenMapping(arrays))
        wrong = {name: length for name, length in lengths.items() if length != frames}
        if wrong:
            raise InputError(f"result: found lengths {wrong}, expected {frames} frames in each")

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.people[0].motion)

    def __repr__(self) -> str:
        return (
            f"Result({len(self)} frames at {self.fps:g} fps, "
            f"{counted(len(self.people), 'person', 'people')}, "
            f"{counted(len(self.objects), 'object')}, {counted(len(self.contacts), 'contact')})"
        )

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.people[0].motion.fps

    @property
    def motion(self) -> Motion:
        """The first person's corrected motion."""
        return self.people[0].motion

    @property
    def reference(self) -> Motion:
        """The first person's reference motion."""
        return self.people[0].reference

    @property
    def recorded(self) -> Motion:
        """The first person's motion as recorded, see `PersonResult.recorded`."""
        return self.people[0].recorded

    @cached_property
    def dents(self) -> Mapping[str, Dent]:
        """The surfaces of soft things over time, by name: of those that something presses.

        Computed on first access, from `soft_contacts`; files do not hold them.
        """
        from halfphysics.results.dents import dents_of

        return dents_of(self)

    @cached_property
    def holds(self) -> tuple[HeldReport, ...]:
        """What became of what hands were to hold: one entry for each hand of each hold.

        Empty where no motion was adapted to what it holds (`halfphysics.adapt`, `load_sequence`),
        and for things that the scene does not have.
        """
        return held(self)

    @property
    def clock(self) -> Array:
        """Time of the first person's reference at every frame (T,) [s]."""
        return cast("Array", self.people[0].clock)

    def free_frames(self, person: int = 0, settle: float = SETTLE) -> NDArray[np.bool_]:
        """Frames (T,) in which nothing acts on a person: no contact within the last `settle` [s],
        and nothing that weight corrects.

        After a contact the deviation decays over a few `Settings.drive_time`; `settle` covers it.

        Raises:
            InputError: There is no such person, or `settle` is no number of at least 0.
        """
        self._check_person(person)
        touched = np.zeros(len(self), dtype=bool)
        hurt = self.contacts.person == person
        touched[self.contacts.frame[hurt & self.contacts.impulse.any(axis=1)]] = True
        touched |= self.people[person].corrected
        settle = number(settle, "settle", least=0.0, unit="s")
        reach = int(np.ceil(min(settle * self.fps, len(self))))
        last = np.where(touched, np.arange(len(self)), -reach - 1)
        return np.arange(len(self)) - np.maximum.accumulate(last) > reach

    def parts(self, person: int = 0) -> PartReport:
        """Clearance, contact, force and displacement of every part in every frame.

        Computed on first access, for all people at once, from the poses at the frames.

        Raises:
            InputError: There is no such person.
            FileError: In a result from a file: a body or a mesh of the scene is missing. Restore
                it, or pass scene= or body= to `Result.load`.
        """
        self._check_person(person)
        return self._parts[person]

    @cached_property
    def _parts(self) -> tuple[PartReport, ...]:
        from halfphysics.metrics.part_report import part_reports

        return part_reports(self)

    def _check_person(self, person: int) -> None:
        if not (is_whole(person, least=0, plain=False) and person < len(self.people)):
            raise InputError(
                f"person: found {shown(person)}, expected 0 to {len(self.people) - 1} "
                f"({len(self.people)} in this result)"
            )

    def summary(self) -> str:
        """The result in words and numbers, 10 to 20 lines for one person.

        Accuracy of following, what was held and what failed of it, floating, slide of feet in
        stance, net force, contacts and their forces, deviation from what was recorded, overlaps at
        the start, motion of objects, minimum distance, lost time. Forces are impulses of a frame
        divided by its length. Missing files of a loaded result (bodies, meshes) are named.
        """
        from halfphysics.metrics.result_report import summary

        return summary(self)

    def to_xarray(self, *, joints: bool = True, vertices: bool = False) -> xarray.Dataset:
        """The result as a dataset with named dimensions, coordinates and units.

        Dimensions are time, person, joint, object, contact, inside, breach, xyz and wxyz; substep
        where they were recorded. The numbers are the result's, and indices of contacts are
        names; what motions say of holds and stiffness is not in it. docs/python.md lists the
        variables.

        Args:
            joints: With `joint_position` (person, time, joint, xyz) [m].
            vertices: With `vertex_position` (person, time, vertex, xyz) [m]: 0.3 MB a frame.

        Raises:
            MissingDependencyError: xarray is missing: pip install 'halfphysics[frames]'.
            FileError: In a result from a file: a body is missing, and joints need it.
            InputError: `vertices` of people with skins of different sizes.
        """
        from halfphysics.results.dataset import to_dataset

        dataset: xarray.Dataset = to_dataset(self, joints=joints, vertices=vertices)
        return dataset

    def plot(
        self,
        what: str | Sequence[str] = ("clearance", "forces", "offsets"),
        *,
        ax: Any = None,
    ) -> Figure:
        """Charts over time, below one another, as a figure of matplotlib.

        Args:
            what: Some of "clearance" (minimum distance to static geometry [mm]), "forces" (of
                contacts between people and things [N]), "offsets" (of joints from the motion as
                recorded, mean and largest [mm]) and "support" (what holds people up [% of the
                weight], which takes seconds).
            ax: Axes to draw into, one for each; None: a new figure.

        Raises:
            MissingDependencyError: matplotlib is missing: pip install 'halfphysics[notebook]'.
            InputError: A chart that does not exist, or another number of axes.
            FileError: In a result from a file: a body is missing.
        """
        from halfphysics.results.plots import plot

        figure: Figure = plot(self, what, ax)
        return figure

    def _notebook_lines(self) -> list[str]:
        """The summary without what takes seconds: how people stand and slide."""
        from halfphysics.metrics.result_report import summary

        return summary(self, brief=True).splitlines()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the result as one npz, whole or not at all.

        At the top level are the keys of the file of the first person's motion (by default AMASS
        keys), so that readers of such files read the corrected motion; the rest is under object/,
        contact/, person/ and meta/ (docs/result-files.md). Body models and meshes are named by path
        and SHA-256, their content is not written.

        Raises:
            FileError: The folder does not exist or cannot be written.
        """
        from halfphysics.formats.results.result_writer import save_result

        save_result(self, path)

    @staticmethod
    def load(
        path: str | os.PathLike[str],
        *,
        scene: Scene | None = None,
        body: Body | tuple[Body, ...] | list[Body] | None = None,
    ) -> Result:
        """Read a file that `save` wrote. Arrays come back bit for bit.

        Args:
            path: The file.
            scene: Replaces the scene that the file names (its meshes may have moved): the same
                names, or some of them.
            body: Replaces the bodies likewise: one, or a sequence of one per person.

        Raises:
            FileError: Missing, damaged, no result file, or of a newer version.
            InputError: Another number of bodies than people, or a scene with other names.
        """
        from halfphysics.formats.results.result_file import load_result

        return load_result(path, scene=scene, body=body)


def _set(instance: Any, name: str, value: Any) -> None:
    object.__setattr__(instance, name, value)
