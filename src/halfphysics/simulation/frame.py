"""One frame of a simulation, and the state between two frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted, short_repr
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.results.inside import Depths
from halfphysics.simulation.core_rows import ContactRows, breach_rows, contact_rows, inside_rows
from halfphysics.simulation.soft_rows import soft_rows

if TYPE_CHECKING:
    from halfphysics.results.soft_contacts import SoftContacts
    from halfphysics.simulation.holding import Hold
    from halfphysics.simulation.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Frame:
    """The state after one `Simulator.step`.

    Poses, objects, contacts and what is inside are worked out when first read: stepping pays for
    none of them.

    Attributes:
        poses: The people's corrected poses.
        objects: Name -> (position (3,) [m], quaternion (4,)); links of articulated objects too.
        joints: Name of an articulated object's joint -> its value () [rad or m], (4,) of a ball.
        contacts: The contacts during the frame.
        inside: Which parts and objects are inside something, and how deep.
        breaches: Of those that were clear before, see `Result.breaches`: empty unless the promise
            was broken that what starts clear stays clear.
        clearance: Minimum distance of the people from the statics [m]; inf beyond
            `Settings.clearance_range`, negative where they penetrate.
        lost_time: Time by which blocked steps were shortened [s].
        corrected: Whether the people's targets were corrected by weight (people,), see
            `PersonResult.corrected`.
        torques: What the drive exerted on the people's joints, see `PersonResult.torque`.
        diagnostics: Numbers of the frame, see `halfphysics.results.result.DIAGNOSTICS`.
        substeps: With `Settings.record="substeps"`: model coordinates (N, nq) after every
            substep, else (0, nq).
    """

    clearance: float
    lost_time: float
    corrected: NDArray[np.bool_]
    diagnostics: Mapping[str, float]
    substeps: Array
    _world: World
    _qpos: Array
    _axes: tuple[Array, ...]
    _set: tuple[Pose, ...] | None  # poses that were set, as they were given
    _contacts: Array
    _inside: Array
    _breaches: Array
    _torques: Array
    _soft: Array | None = None

    @cached_property
    def poses(self) -> tuple[Pose, ...]:
        if self._set is not None:
            return self._set
        people = zip(self._world.people, self._axes, strict=True)
        return tuple(Pose.trusted(*person.pose(self._qpos, axes), axes) for person, axes in people)

    @cached_property
    def objects(self) -> Mapping[str, tuple[Array, Array]]:
        return {place.name: place.pose(self._qpos) for place in self._world.tracked}

    @cached_property
    def joints(self) -> Mapping[str, Array]:
        return {joint.name: joint.values(self._qpos) for joint in self._world.joints}

    @cached_property
    def contacts(self) -> ContactRows:
        return contact_rows(self._world, self._contacts)[0]

    @cached_property
    def inside(self) -> Depths:
        return inside_rows(self._world, self._inside, np.zeros(len(self._inside), dtype=int)).at(0)

    @cached_property
    def breaches(self) -> Depths:
        frame = np.zeros(len(self._breaches), dtype=int)
        return breach_rows(self._world, self._breaches, frame).at(0)

    @cached_property
    def soft_contacts(self) -> SoftContacts | None:
        """Samples under pressure, all of frame 0; None: nothing in the world is soft."""
        if self._soft is None:
            return None
        return soft_rows(self._world, self._soft, np.zeros(len(self._soft), dtype=np.int64))

    @cached_property
    def torques(self) -> tuple[Array, ...]:
        people = self._world.people
        if not len(self._torques):
            return tuple(np.zeros((N_JOINTS, 3)) for _ in people)
        return tuple(self._world.torques_from_core(self._torques))

    @property
    def torque(self) -> Array:
        """The first person's (55, 3) [N m], in the joints' own frames."""
        return self.torques[0]

    @property
    def pose(self) -> Pose:
        """The first person's pose."""
        return self.poses[0]

    def __getstate__(self) -> dict[str, Any]:
        """For copies and other processes: everything worked out, the simulator left behind."""
        done = {
            "poses": self.poses,
            "objects": self.objects,
            "joints": self.joints,
            "contacts": self.contacts,
            "inside": self.inside,
            "breaches": self.breaches,
            "torques": self.torques,
            "soft_contacts": self.soft_contacts,
        }
        return done | {name: v for name, v in vars(self).items() if not name.startswith("_")}

    def __repr__(self) -> str:
        return (
            f"Frame({counted(len(self.poses), 'person', 'people')}, "
            f"{counted(len(self.objects), 'object')}, "
            f"{counted(len(self.contacts.part), 'contact')}, clearance {self.clearance:g} m)"
        )


@dataclass(frozen=True)
class State:
    """All that a simulation remembers between frames; `Simulator.set_state` resumes bit-exactly."""

    numbers: bytes
    axes: tuple[Array, ...]
    signature: str
    held: Mapping[str, Hold] = field(default_factory=dict)

    __repr__ = short_repr
