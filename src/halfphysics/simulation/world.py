"""The world of a simulation: the core, and what its shapes and coordinates stand for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted
from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.scene import articulated as jointed
from halfphysics.simulation import coordinates
from halfphysics.simulation.compiled_model import armature_of, compile_model
from halfphysics.simulation.coordinates import FreeObject, Person
from halfphysics.simulation.fingerprint import fingerprint
from halfphysics.simulation.soft_shapes import anything_soft

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.holding import HeldObject, Hold
    from halfphysics.simulation.joined_model import JoinedModel
    from halfphysics.simulation.names import Names

Array = NDArray[np.float64]


@dataclass(eq=False, repr=False)
class World:
    """People and a scene in the core; `build_world` makes one.

    Attributes:
        bodies, scene, settings: What it was made of.
        held: Name of an object -> how a person holds it: it has no coordinates of its own.
        made_of: The scene as it was then: later changes to `scene` do not change the world.
        called: Names of everything.
        joined: The arrays of the core's model.
        stepper: The native stepper: the core.
        stiffness: Stiffness of every joint by the settings (55,).
        people, objects, links, joints: Their places in the coordinates.
        shape_name: Per shape of the core that moves: index into `names`.
        shape_part: Per shape of the core that moves: joint index of a person's part, else -1.
        static_name: Per shape of static geometry: index into `names`.
    """

    bodies: tuple[Body, ...]
    scene: Scene
    settings: Settings
    held: Mapping[str, Hold]
    made_of: Scene
    called: Names
    joined: JoinedModel
    stepper: Any
    stiffness: Array
    people: tuple[Person, ...]
    objects: tuple[FreeObject | HeldObject, ...]
    links: tuple[jointed.LinkPlace, ...]
    joints: tuple[jointed.JointPlace, ...]
    shape_name: NDArray[np.int64]
    shape_part: NDArray[np.int64]
    static_name: NDArray[np.int64]

    def __repr__(self) -> str:
        return (
            f"World({counted(len(self.bodies), 'person', 'people')}, "
            f"{counted(len(self.made_of.statics), 'static')}, "
            f"{counted(len(self.tracked), 'object')})"
        )

    @property
    def names(self) -> tuple[str, ...]:
        """What contacts refer to: statics, objects, links, people, in this order."""
        return self.called.everything

    @property
    def nq(self) -> int:
        """Number of coordinates."""
        return self.joined.nq

    @property
    def nv(self) -> int:
        """Number of velocities."""
        return self.joined.nv

    @cached_property
    def model(self) -> Any:
        """A `mujoco.MjModel` of the same numbers, compiled when first asked for."""
        people, armature = self.called.people, armature_of(self.stiffness)
        return compile_model(self.bodies, people, self.made_of, self.held, armature)

    @cached_property
    def soft(self) -> bool:
        """Whether something in it is soft: pressures are recorded."""
        return anything_soft(self.made_of, self.settings)

    @cached_property
    def signature(self) -> str:
        """Differs where people or items do, however they are held: which states fit."""
        return f"{self.called.everything} {fingerprint(self.bodies, self.made_of)}"

    def changed(self, scene: Scene, settings: Settings) -> None:
        """Keep what the world is made of from now on."""
        self.scene, self.made_of, self.settings = scene, scene._copied(), settings
        for derived in ("model", "signature"):
            vars(self).pop(derived, None)

    @property
    def tracked(self) -> tuple[FreeObject | HeldObject | jointed.LinkPlace, ...]:
        """All that has a pose of its own in results, in the order of `names`."""
        return (*self.objects, *self.links)

    def unknown_object(self, name: object) -> str:
        """The words for a name that no object has."""
        known = [place.name for place in self.objects]
        hint = did_you_mean(name, known, form=repr, otherwise=".")
        there = ", ".join(known) or "none"
        return f"there is no object called {shown(name)}{hint} There are: {there}"

    def reset(self, poses: Sequence[Pose]) -> None:
        """Put the people at `poses` and objects at their start; the core forgets all else."""
        self.stepper.reset(*self.start(poses))
        self.stepper.set_stiffness(self.stiffness_to_core(np.tile(self.stiffness, (len(poses), 1))))

    def start(self, poses: Sequence[Pose]) -> tuple[Array, Array]:
        """Coordinates (nq,) and velocities (nv,) with people at `poses`, objects at their start."""
        qpos, qvel = np.zeros(self.nq), np.zeros(self.nv)
        for person, pose in zip(self.people, poses, strict=True):
            q = person.coordinates(pose.translation[None], pose.rotations[None], pose.axes)
            qpos[person.qpos : person.qpos + person.count] = q[0]
        self.place_objects(qpos, qvel)
        return qpos, qvel

    def place_objects(self, qpos: Array, qvel: Array) -> None:
        """Puts the objects where they start, into coordinates (nq,) and velocities (nv,)."""
        for place, item in zip(self.objects, self.made_of.objects.values(), strict=True):
            if isinstance(place, FreeObject):
                place.put_at_start(item, qpos, qvel)
        for articulated in self.made_of.articulated.values():
            jointed.start(self.joined, articulated, qpos, qvel)

    @cached_property
    def shape_keys(self) -> tuple[tuple[str, int, int], ...]:
        """What tells the core's shapes apart: name, part, and which of several."""
        seen: Counter[tuple[str, int]] = Counter()
        keys = []
        for name, part in zip(self.shape_name.tolist(), self.shape_part.tolist(), strict=True):
            key = (self.names[name], part)
            keys.append((*key, seen[key]))
            seen[key] += 1
        return tuple(keys)

    def targets(self, poses: Sequence[Pose]) -> Array:
        """What the core's frame() takes: all people's coordinates, one after the other."""
        return np.concatenate(
            [
                person.coordinates(pose.translation[None], pose.rotations[None], pose.axes)[0]
                for person, pose in zip(self.people, poses, strict=True)
            ]
            or [np.zeros(0)]
        )

    def motion_coordinates(self, motions: Sequence[Motion]) -> Array:
        """Targets (T, .) of whole motions of one length."""
        each = [
            person.coordinates(m.translation, m.rotations, m.axes)
            for person, m in zip(self.people, motions, strict=True)
        ]
        return each[0] if len(each) == 1 else np.concatenate(each, axis=1)

    def stiffness_to_core(self, stiffness: Array) -> Array:
        """Stiffness (..., people, 55) in the order of the core (..., balls)."""
        return coordinates.joints_to_core(self.people, stiffness)

    def stiffness_from_core(self, balls: Array) -> Array:
        """The reverse of `stiffness_to_core`: (people, 55)."""
        return self.torques_from_core(np.repeat(balls[:, None], 3, axis=1))[..., 0]

    def torques_from_core(self, balls: Array) -> Array:
        """Torques (..., people, 55, 3) [N m] from those of the core (..., balls, 3)."""
        return coordinates.joints_from_core(self.people, balls)
