"""A right hand clasps another right hand: fingers around its edge, thumb over its back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.joint_ranges import JointRanges, from_swing_twist, swing_twist
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

_FINGERS = ("index", "middle", "ring", "pinky")
#: Flexion of a finger's joints, knuckle to tip [rad], open and closed.
_OPEN = np.radians([3.0, 6.0, 4.0])
_CLOSED = np.radians([5.0, 75.0, 50.0])
#: Directions of the thumb's bones, root to tip, open and closed. Components: along the fingers,
#: along the palm's normal, towards the thumb's side.
_THUMB_UP = np.array([[-0.25, 0.0, 1.0], [-0.2, 0.0, 1.0], [-0.1, 0.0, 1.0]])
_THUMB_OVER = np.array([[0.0, 0.5, 0.9], [0.1, 1.0, 0.3], [0.2, 0.8, -0.6]])


def fingers(body: Body, closed: Array) -> dict[int, Array]:
    """Rotations of the right hand's finger joints.

    Args:
        body: The person's body.
        closed: 0 (straight fingers, thumb up) to 1 (around the other hand), (T,).

    Returns:
        Joint index -> axis-angle (T, 3) in the parent's frame. The thumb goes as far to where it
        should be as a thumb goes.
    """
    ranges = JointRanges.of(body)
    turns = {}
    for name in _FINGERS:
        for k in range(3):
            # About the finger's own axis, which is not quite the hand's.
            joint = JOINT_INDEX[f"right_{name}{k + 1}"]
            flexed = _OPEN[k] + closed * (_CLOSED[k] - _OPEN[k])
            turns[joint] = flexed[:, None] * ranges.axes[joint, 1]
    opened, over = (_thumb(body, to) for to in (_THUMB_UP, _THUMB_OVER))
    for joint in opened:
        axes = ranges.axes[joint]
        start, end = (
            np.clip(
                swing_twist(rot.from_matrix(to), axes), ranges.lower[joint], ranges.upper[joint]
            )
            for to in (opened[joint], over[joint])
        )
        turns[joint] = from_swing_twist(start + closed[:, None] * (end - start), axes)
    return turns


def _thumb(body: Body, directions: Array) -> dict[int, Array]:
    """Rotations (3, 3) of the thumb's joints that align its bones with directions (3, 3)."""
    joints = [JOINT_INDEX[f"right_thumb{k}"] for k in (1, 2, 3)]
    rest = np.asarray(body.rest_joints)
    tip = _tip(body, joints[-1])
    before, turns = np.eye(3), {}
    for joint, end, to in zip(joints, (*rest[joints[1:]], tip), directions, strict=True):
        # At rest a right hand's fingers point along -x, its palm faces -y, its thumb is at +z.
        turn = _shortest(end - rest[joint], to * [-1.0, -1.0, 1.0])
        turns[joint] = before.T @ turn
        before = turn
    return turns


def _tip(body: Body, joint: int) -> Array:
    """The end of the last bone at rest (3,): the vertex of its skin farthest from the wrist."""
    wrist = body.rest_joints[JOINT_INDEX["right_wrist"]]
    own = body.main_joint == joint
    skin = np.asarray(body.rest_vertices)[own]
    tip: Array = skin[np.linalg.norm(skin - wrist, axis=1).argmax()]
    return tip


def _shortest(a: Array, b: Array) -> Array:
    """The smallest rotation (3, 3) from the direction of `a` to that of `b`."""
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.eye(3)
    turn: Array = rot.rotvec_to_matrix(axis / sine * np.arctan2(sine, a @ b))
    return turn
