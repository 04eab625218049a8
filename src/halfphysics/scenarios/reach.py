"""Arms: the joints that put a hand where it should be, turned as it should be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body import Body

Array = NDArray[np.float64]

#: An arm is never stretched further than this part of its length: a straight elbow snaps.
REACH = 0.99


@dataclass(frozen=True)
class Arm:
    """One arm of a body at rest, rest frame [m].

    Attributes:
        joints: Indices of shoulder, elbow and wrist joint.
        collar: Index of the collar joint, the shoulder's parent.
        upper: Elbow from shoulder, (3,).
        fore: Wrist from elbow, (3,).
        side: 1 for the left arm, -1 for the right one.
    """

    joints: tuple[int, int, int]
    collar: int
    upper: Array
    fore: Array
    side: float

    @property
    def length(self) -> float:
        """Longest distance from shoulder to wrist that the arm is used at [m]."""
        return REACH * float(np.linalg.norm(self.upper) + np.linalg.norm(self.fore))


def arm_of(body: Body, side: str) -> Arm:
    """The `side` ("left" or "right") arm of a body."""
    shoulder, elbow, wrist = (JOINT_INDEX[f"{side}_{n}"] for n in ("shoulder", "elbow", "wrist"))
    joints = np.asarray(body.rest_joints)
    return Arm(
        (shoulder, elbow, wrist),
        JOINT_INDEX[f"{side}_collar"],
        joints[elbow] - joints[shoulder],
        joints[wrist] - joints[elbow],
        1.0 if side == "left" else -1.0,
    )


def solve(
    arm: Arm, collar: Array, shoulder: Array, wrist: Array, hand: Array, elbow: Array
) -> dict[int, Array]:
    """Rotations of one arm that put its wrist and hand where they should be.

    Two bones in a plane that holds shoulder and wrist, the elbow on the side asked for; a target
    out of reach is approached along its own line. The forearm takes half of the hand's twist
    about it, the wrist the rest.

    Args:
        arm: The arm at rest.
        collar: World rotation of the collar, (T, 3, 3).
        shoulder: World position of the shoulder joint [m], (T, 3).
        wrist: Where the wrist joint should be [m], (T, 3).
        hand: World rotation that the hand should have, (T, 3, 3).
        elbow: Direction from the line of shoulder and wrist to the elbow, (3,) or (T, 3).

    Returns:
        Joint index -> axis-angle (T, 3) in the parent's frame.
    """
    a, b = np.linalg.norm(arm.upper), np.linalg.norm(arm.fore)
    line = wrist - shoulder
    distance = np.clip(np.linalg.norm(line, axis=1), abs(a - b) + 1e-6, arm.length)
    line = line / np.linalg.norm(line, axis=1, keepdims=True)
    out = np.broadcast_to(elbow, line.shape)
    out = out - np.sum(out * line, axis=1, keepdims=True) * line
    out = out / np.linalg.norm(out, axis=1, keepdims=True)
    cosine = (a * a + distance**2 - b * b) / (2.0 * a * distance)
    sine = np.sqrt(np.clip(1.0 - cosine**2, 0.0, None))
    bend = (a * cosine)[:, None] * line + (a * sine)[:, None] * out
    end = distance[:, None] * line
    # At rest an elbow bends forward about its hinge, which is vertical: the elbow is behind.
    hinge = arm.side * np.cross(line, out)
    upper = _bone(arm.upper, bend, hinge)
    fore = _bone(arm.fore, end - bend, hinge)
    twist = _twist(np.swapaxes(fore, 1, 2) @ hand, arm.fore)
    axis = arm.fore / np.linalg.norm(arm.fore)
    fore = fore @ rot.rotvec_to_matrix(0.5 * twist[:, None] * axis)
    locals_ = (
        np.swapaxes(collar, 1, 2) @ upper,
        np.swapaxes(upper, 1, 2) @ fore,
        np.swapaxes(fore, 1, 2) @ hand,
    )
    return {j: rot.matrix_to_rotvec(m) for j, m in zip(arm.joints, locals_, strict=True)}


def palm_frame(side: str, fingers: Array, facing: Array) -> Array:
    """World rotation (T, 3, 3) of a flat hand.

    Args:
        side: "left" or "right".
        fingers: Where the fingers point, (T, 3) or (3,).
        facing: Where the palm faces, (T, 3) or (3,), made square to `fingers`.
    """
    left = 1.0 if side == "left" else -1.0
    along, facing = np.broadcast_arrays(np.atleast_2d(fingers), np.atleast_2d(facing))
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    facing = facing - np.sum(facing * along, axis=1, keepdims=True) * along
    facing = facing / np.linalg.norm(facing, axis=1, keepdims=True)
    # At rest the fingers of the left hand point along x, those of the right one back, palms down.
    x, y = left * along, -facing
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _bone(rest: Array, actual: Array, hinge: Array) -> Array:
    """Rotations (T, 3, 3) taking a rest vector (3,) to `actual` (T, 3) and y toward `hinge`."""

    def frame(along: Array, across: Array) -> Array:
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        across = across - np.sum(across * along, axis=-1, keepdims=True) * along
        across = across / np.linalg.norm(across, axis=-1, keepdims=True)
        return np.stack([along, across, np.cross(along, across)], axis=-1)

    return frame(actual, hinge) @ frame(rest, np.array([0.0, 1.0, 0.0])).T


def _twist(turn: Array, axis: Array) -> Array:
    """Angles (T,) of rotations (T, 3, 3) about an axis (3,), in (-pi, pi]."""
    quaternion = rot.from_matrix(turn)
    along = quaternion[:, 1:] @ (axis / np.linalg.norm(axis))
    angle = 2.0 * np.arctan2(along, quaternion[:, 0])
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
