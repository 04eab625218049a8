"""From a frame of the session to messages, and from messages to poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET

from halfphysics.live import schema
from halfphysics.live.incoming import IncomingPose, Outgoing, Stamp
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from halfphysics.live.schema import Part

_UPRIGHT = np.eye(3)


@dataclass(frozen=True)
class Subscription:
    """What a client wants of frames.

    Attributes:
        parts: The parts.
        people: The people's names; None: everybody.
        rate: Frames per second; None: every frame.
    """

    parts: frozenset[Part] = frozenset(schema.USUAL_PARTS) - {"targets"}
    people: frozenset[str] | None = None
    rate: float | None = None

    @staticmethod
    def of(message: schema.Subscribe) -> Subscription:
        """The subscription of a message."""
        return Subscription(
            frozenset(schema.USUAL_PARTS if message.parts is None else message.parts),
            None if message.people is None else frozenset(message.people),
            message.rate,
        )

    @property
    def content(self) -> tuple[frozenset[Part], frozenset[str] | None]:
        """What decides the bytes: clients of one content and encoding get the same ones."""
        return self.parts, self.people


def frame_message(frame: Outgoing, wanted: Subscription) -> schema.FrameMessage:
    """The message of a frame."""
    parts = wanted.parts
    people = {
        name: _person(frame, name, wanted)
        for name in frame.poses
        if wanted.people is None or name in wanted.people
    }
    objects: Any = UNSET
    joints: Any = UNSET
    if "objects" in parts:
        objects = {n: schema.Place(p.tolist(), q.tolist()) for n, (p, q) in frame.objects.items()}
    if "joints" in parts:
        joints = {name: np.asarray(value).tolist() for name, value in frame.joints.items()}
    return schema.FrameMessage(
        frame=frame.frame,
        time=frame.time,
        clock=frame.clock,
        clearance=frame.clearance if math.isfinite(frame.clearance) else None,
        people=people,
        objects=objects,
        joints=joints,
        contacts=list(_contacts(frame)) if "contacts" in parts else UNSET,
        pressures=list(_pressures(frame)) if "pressures" in parts else UNSET,
    )


def incoming_poses(message: schema.PoseMessage, source: str) -> list[IncomingPose]:
    """The poses of a message, checked by the schema already."""
    time = message.time if message.time is not None and math.isfinite(message.time) else None
    return [
        IncomingPose(
            person=name,
            pose=Pose.trusted(np.array(its.translation), np.array(its.rotations), _UPRIGHT),
            time=time,
            tracked=None if its.tracked is None else np.array(its.tracked, dtype=bool),
            source=source,
        )
        for name, its in message.people.items()
    ]


def _person(frame: Outgoing, name: str, wanted: Subscription) -> schema.PersonFrame:
    stamp = frame.stamps.get(name)
    person = schema.PersonFrame(
        frame.tracking.get(name, "live"), None if stamp is None else _stamp(stamp)
    )
    if "poses" in wanted.parts:
        pose = frame.poses[name]
        person.translation, person.rotations = pose.translation.tolist(), pose.rotations.tolist()
    if "targets" in wanted.parts and name in frame.targets:
        pose = frame.targets[name]
        person.target_translation = pose.translation.tolist()
        person.target_rotations = pose.rotations.tolist()
    return person


def _stamp(stamp: Stamp) -> schema.StampItem:
    return schema.StampItem(stamp.sent, stamp.received, stamp.stepped)


def _contacts(frame: Outgoing) -> Iterator[schema.Contact]:
    rows, names = frame.contacts, frame.names
    people = names[len(names) - len(frame.poses) :]
    columns = zip(
        rows.person.tolist(),
        rows.part.tolist(),
        rows.subject.tolist(),
        rows.other.tolist(),
        rows.other_part.tolist(),
        rows.position.tolist(),
        rows.normal.tolist(),
        (rows.impulse / frame.dt).tolist(),
        strict=True,
    )
    for person, part, subject, other, other_part, position, normal, force in columns:
        yield schema.Contact(
            people[person] if person >= 0 else names[subject],
            JOINT_NAMES[part] if part >= 0 else None,
            names[other],
            JOINT_NAMES[other_part] if other_part >= 0 else None,
            position,
            normal,
            force,
        )


def _pressures(frame: Outgoing) -> Iterator[schema.Pressed]:
    """What is under pressure, pair by pair; rounded to what can be seen."""
    rows = None if frame.simulated is None else frame.simulated.soft_contacts
    if rows is None:
        return
    for layer, other in np.unique(np.column_stack([rows.layer, rows.other]), axis=0).tolist():
        mine = rows[(rows.layer == layer) & (rows.other == other)]
        yield schema.Pressed(
            frame.names[layer],
            frame.names[other],
            np.round(mine.position, 5).tolist(),
            np.round(mine.normal, 4).tolist(),
            np.round(mine.depth, 6).tolist(),
            np.round(mine.pressure, 1).tolist(),
            np.round(mine.area, 8).tolist(),
        )
