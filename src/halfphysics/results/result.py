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
from halfphysics.base.short_repr import counted, numbers
from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import checked
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.contacts import Contacts
from halfphysics.results.deferred import Deferred, typed, typed_or_deferred
from halfphysics.results.held import HeldReport, held
from halfphysics.results.inside import Breaches, Inside
from halfphysics.results.naming import Naming
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.results.substeps import Substeps
from halfphysics.results.surroundings import Surroundings
from halfphysics.settings import Settings

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from halfphysics.body.body import Body
    from halfphysics.metrics.part_report import PartReport
    from halfphysics.scene.scene import Scene
    from halfphysics.support.support import Support

Array = NDArray[np.float64]

#: Time after a contact until the body is on its reference again: a deviation of 2 rad returns in
#: 0.25 s at the default `Settings.recovery_rate`, then twelve time constants of the drive [s].
SETTLE = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectTrack(ReadOnly):
    """Poses of an object: `position` (T, 3) [m] and `quaternion` (T, 4) of its own frame."""

    position: Array
    quaternion: Array

    def __post_init__(self) -> None:
        _set(self, "position", checked("position", self.position, (None, 3), "(T, 3)"))
        _set(self, "quaternion", checked("quaternion", self.quaternion, (None, 4), "(T, 4)"))
        if len(self.position) != len(self.quaternion):
            raise InputError(
                f"position has {len(self.position)} frames and quaternion {len(self.quaternion)}; "
                "expected the same number"
            )

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        ends = f"{numbers(self.position[0])} to {numbers(self.position[-1])} m" if len(self) else ""
        return f"ObjectTrack({counted(len(self), 'frame')}, {ends})"


@dataclass(frozen=True, kw_only=True, eq=False)
class PersonResult(InNotebook, ReadOnly):
    """One person of a result.

    Attributes:
        name: As in `Result.names`.
        motion: The simulated motion.
        reference: The reference motion, which the physics follows, with the same frames and frame
            rate; `recorded` is what measures compare with.
        body: The person's body. In a result from a file it is loaded on first access; raises
            `FileError` if a licensed model is missing or has changed (see `Result.load`).
        torque: Torque of the drive on the joints (T, 55, 3) [N m], mean over (t-1, t], in the frame
            of the joint's child, row 0 on the whole body: zero in free motion, against the
            contacts otherwise. See docs/physics.md. None: unknown (older files).
        clock: Time of the reference at every frame (T,) [s]: that of the frame, less what the
            person has waited (`Settings.blocked`); given None, it never waited.
        corrected: Frames (T,) in which the reference was put on what is under it
            (`Settings.weight`); given None, none.
        surroundings: What was around the person; `Result` sets it.
    """

    name: str
    motion: Motion
    reference: Motion
    body: Deferred[Body] = Deferred()
    torque: Array | None = None
    clock: Array | None = None
    corrected: NDArray[np.bool_] | None = None
    surroundings: Surroundings | None = None

    def __post_init__(self) -> None:
        from halfphysics.body.body import Body

        typed("motion", self.motion, Motion)
        typed("reference", self.reference, Motion)
        typed_or_deferred("body", vars(self)["_body"], Body)
        if len(self.motion) != len(self.reference):
            raise InputError(
                f"person {self.name!r}: the motion has {len(self.motion)} frames and the "
                f"reference {len(self.reference)}; expected the same number"
            )
        if self.torque is not None:
            shape = (len(self.motion), N_JOINTS, 3)
            # A read-only array is the core's own: mostly zeros, which take no memory.
            own = isinstance(self.torque, np.ndarray) and not self.torque.flags.writeable
            if not own or self.torque.shape != shape:
                _set(self, "torque", checked("torque", self.torque, shape, "(T, 55, 3)"))

        count = len(self.motion)
        clock = np.arange(count) / self.motion.fps if self.clock is None else self.clock
        _set(self, "clock", checked("clock", clock, (count,), "(T,)"))
        corrected = np.zeros(count) if self.corrected is None else self.corrected
        flags = checked("corrected", corrected, (count,), "(T,)") != 0.0
        flags.setflags(write=False)
        _set(self, "corrected", flags)
        _set(self, "motion", self.motion.bare())  # what was to be held is the reference's

    def __repr__(self) -> str:
        off = np.linalg.norm(self.motion.translation - self.recorded.translation, axis=1).max()
        return (
            f"PersonResult({self.name}: {len(self.motion)} frames at {self.motion.fps:g} fps, "
            f"root up to {1000.0 * off:.3g} mm off its path)"
        )

    @property
    def recorded(self) -> Motion:
        """What was asked for: the reference, or what was recorded where it was adapted to it."""
        return self.reference if self.reference.recorded is None else self.reference.recorded

    @cached_property
    def support(self) -> Support:
        """What holds the person up: forces, centres of pressure, joint torques with gravity, and
        the residual that nothing could supply. Computed on first access; files do not hold it.

        Raises:
            InputError: The person is of no result.
            FileError: In a result from a file: the body or a mesh of the scene is missing.
        """
        from halfphysics.support.estimate import support_of

        if self.surroundings is None:
            raise InputError(
                f"person {self.name!r}: found no result that it is of, expected one of "
                "Result.people. Of a motion alone: halfphysics.support.estimate(motion, scene)"
            )
        return support_of(self.motion, self.body, self.surroundings)

    def joint_errors(self, *, driven: bool = False) -> tuple[Array, Array]:
        """Distances (T, 55) [m] of joints from `recorded`: relative to the pelvis, global.

        Args:
            driven: From the `reference` instead: how exactly it was followed.
        """
        asked = self.reference if driven else self.recorded
        p, q = self.body.joints(self.motion), self.body.joints(asked)
        local = np.linalg.norm((p - p[:, :1]) - (q - q[:, :1]), axis=-1)
        return local, np.linalg.norm(p - q, axis=-1)


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
        contacts: The contacts, one row per pair and frame.
        clearance: Minimum distance of the people from the statics in every frame (T,) [m]; inf
            beyond `Settings.clearance_range`, negative: penetration.
        lost_time: Time by which blocked steps were shortened, per frame (T,) [s].
        settings: Settings of the simulation.
        substeps: Every committed pose, with ``Settings(record="substeps")``, else None.
        diagnostics: Name -> number of every frame (T,), see `DIAGNOSTICS`; empty where unknown.
        joints: "NAME/JOINT" of an articulated object -> its value of every frame (T,) [rad or m],
            quaternions (T, 4) of a ball joint. Links are among the `objects`: "NAME/LINK".
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
        typed_or_deferred("scene", vars(self)["_scene"], Scene)
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
        """
        self._check_person(person)
        touched = np.zeros(len(self), dtype=bool)
        hurt = self.contacts.person == person
        touched[self.contacts.frame[hurt & self.contacts.impulse.any(axis=1)]] = True
        touched |= self.people[person].corrected
        reach = int(np.ceil(settle * self.fps))
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
        where they were recorded. Nothing is lost: the numbers are the result's, and indices of
        contacts are names. docs/python.md lists the variables.

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
            scene: Replaces the scene that the file names (its meshes may have moved).
            body: Replaces the bodies likewise: one, or a sequence of one per person.

        Raises:
            FileError: Missing, damaged, no result file, or of a newer version.
            InputError: Another number of bodies than people.
        """
        from halfphysics.formats.results.result_file import load_result

        return load_result(path, scene=scene, body=body)


def _set(instance: Any, name: str, value: Any) -> None:
    object.__setattr__(instance, name, value)
