"""What an actor sees at the begin of a frame: itself, other people, objects, contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.simulation.core_rows import ContactRows
    from halfphysics.simulation.frame import Frame
    from halfphysics.simulation.simulator import Simulator

Array = NDArray[np.float64]
Placed = tuple[Array, Array]

_FEET = tuple(JOINT_INDEX[f"{side}_{n}"] for side in ("left", "right") for n in ("ankle", "foot"))


@dataclass(frozen=True, eq=False)
class Other:
    """Another person.

    Attributes:
        pose: Its simulated pose.
        body: Its body.
    """

    pose: Pose
    body: Body

    @property
    def pelvis(self) -> Array:
        """Position of its pelvis (3,) [m]."""
        return pelvis_of(self.pose, self.body)


def pelvis_of(pose: Pose, body: Body) -> Array:
    """Position of the pelvis (3,) [m] of a body in a pose."""
    at: Array = pose.axes @ body.rest_joints[0] + pose.translation
    return at


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """The world at one moment, through the eyes of one person.

    Attributes:
        time: Since the reset [s].
        pose: The person's own simulated pose; None: nobody simulates, the reference is the pose.
        others: Index of every other person -> its pose and body.
        objects: Name -> (position (3,) [m], quaternion (4,)).
        contacts: Contacts of the last frame; None: none are known.
        person: Index of the person in `contacts`.
        names: What `contacts.other` refers to.
        held: Names of the objects that the person itself holds (`Simulator.attach`): they are not
            in its way.
    """

    time: float = 0.0
    pose: Pose | None = None
    others: Mapping[Any, Other] = field(default_factory=dict)
    objects: Mapping[str, Placed] = field(default_factory=dict)
    contacts: ContactRows | None = None
    person: int = 0
    names: Sequence[str] = ()
    held: frozenset[str] = frozenset()

    @classmethod
    def of(cls, sim: Simulator, frame: Frame, person: int = 0, *, time: float = 0.0) -> Seen:
        """What one person sees of a frame.

        Args:
            sim: The simulator.
            frame: As its `reset` or `step` gave it.
            person: Index of the person.
            time: Since the reset [s].
        """
        both = zip(frame.poses, sim.bodies, strict=True)
        people = {i: Other(pose, body) for i, (pose, body) in enumerate(both)}
        own = people.pop(person)
        return cls(
            time=time,
            pose=own.pose,
            others=people,
            objects=frame.objects,
            contacts=frame.contacts,
            person=person,
            names=sim.names,
            held=frozenset(name for name, (who, _) in sim.held.items() if who == person),
        )

    @property
    def push(self) -> Array:
        """Impulse on the person but for its feet during the last frame (3,) [N s]."""
        rows = self.contacts
        if rows is None or not len(rows.part):
            return np.zeros(3)
        mine = (rows.person == self.person) & ~np.isin(rows.part, _FEET)
        total: Array = rows.impulse[mine].sum(axis=0)
        return total

    @property
    def touched_at(self) -> Array:
        """Where the person touches anything, but with its feet (n, 3) [m]."""
        rows = self.contacts
        if rows is None or not len(rows.part):
            return np.zeros((0, 3))
        mine = (rows.person == self.person) & ~np.isin(rows.part, _FEET)
        places: Array = rows.position[mine]
        return places

    @property
    def touched(self) -> frozenset[str]:
        """Names of what the person touched, but for what its feet stand on."""
        rows = self.contacts
        if rows is None or not len(rows.part) or not len(self.names):
            return frozenset()
        mine = (rows.person == self.person) & ~np.isin(rows.part, _FEET)
        return frozenset(self.names[i] for i in rows.other[mine])
