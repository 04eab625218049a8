"""Arms: rotations of shoulder, elbow and wrist for a target of the hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Largest extension of an arm as a fraction of its length: a straight elbow snaps.
REACH = 0.99
#: The forearm's part of the twist of a hand, the rest is the wrist's: as their ranges are, 90 to 45
#: degrees (`halfphysics.body.joint_ranges`).
FOREARM = 2.0 / 3.0


@dataclass(frozen=True)
class Arm:
    """One arm of a body at rest, rest frame [m].

    Attributes:
        collar: Index of the collar joint, the parent of the shoulder.
        joints: Indices of shoulder, elbow and wrist.
        upper: Elbow from shoulder, (3,).
        fore: Wrist from elbow, (3,).
    """

    collar: int
    joints: tuple[int, int, int]
    upper: Array
    fore: Array

    @property
    def length(self) -> float:
        """Largest distance from shoulder to wrist in use [m]."""
        return REACH * float(np.linalg.norm(self.upper) + np.linalg.norm(self.fore))


def arm_of(body: Body, side: str) -> Arm:
    """The `side` ("left" or "right") arm of a body."""
    collar, *joints = (JOINT_INDEX[f"{side}_{n}"] for n in ("collar", "shoulder", "elbow", "wrist"))
    shoulder, elbow, wrist = np.asarray(body.rest_joints)[joints]
    return Arm(
        collar,
        (joints[0], joints[1], joints[2]),
        elbow - shoulder,
        wrist - elbow,
    )


def solve(
    arm: Arm,
    collar: Array,
    shoulder: Array,
    wrist: Array,
    hand: Array,
    pole: Array,
    *,
    one_motion: bool = True,
) -> dict[int, Array]:
    """Rotations of one arm for a target of its wrist and hand.

    Both bones lie in the plane of shoulder, wrist and pole, with the elbow on the pole's side; a
    target out of reach is approached along the line to it. Elbow and wrist take half of the
    forearm's twist each; the twist is unwrapped over the frames, so that it may exceed half a turn.

    Args:
        arm: The arm at rest.
        collar: World rotation of the collar, (T, 3, 3).
        shoulder: World position of the shoulder [m], (T, 3).
        wrist: Target position of the wrist [m], (T, 3).
        hand: Target world rotation of the hand, (T, 3, 3).
        pole: Direction of the elbow, (3,) or (T, 3), not parallel to the line shoulder-wrist.
        one_motion: Whether the rows are the frames of one motion; else each is for itself, its
            twist within half a turn.

    Returns:
        Joint index -> axis-angle (T, 3) in the parent's frame.
    """
    a, b = float(np.linalg.norm(arm.upper)), float(np.linalg.norm(arm.fore))
    line = wrist - shoulder
    distance = np.clip(np.linalg.norm(line, axis=1), abs(a - b) + 1e-6, arm.length)
    line = line / np.linalg.norm(line, axis=1, keepdims=True)
    pole = np.broadcast_to(pole, line.shape)
    front = pole - np.sum(pole * line, axis=1, keepdims=True) * line
    front = front / np.linalg.norm(front, axis=1, keepdims=True)
    cosine = (a * a + distance**2 - b * b) / (2.0 * a * distance)
    sine = np.sqrt(np.clip(1.0 - cosine**2, 0.0, None))
    along = cosine[:, None] * line + sine[:, None] * front  # of the upper arm, unit
    end = (distance[:, None] * line - a * along) / b
    # The elbow bends about the y axis of the rest frame.
    hinge = rot.cross(line, front) * np.sign(arm.upper[0])
    upper, fore = _bone(arm.upper, along, hinge), _bone(arm.fore, end, hinge)
    turn = rot.normalize(rot.from_matrix(np.swapaxes(fore, 1, 2) @ hand))
    axis = arm.fore / b
    if one_motion:
        twist = np.unwrap(2.0 * np.arctan2(turn[:, 1:] @ axis, turn[:, 0]))
    else:  # no product of matrices: its bits would depend on the number of rows
        twist = 2.0 * np.arctan2(np.sum(turn[:, 1:] * axis, axis=1), turn[:, 0])
        twist = (twist + np.pi) % (2.0 * np.pi) - np.pi
    part = rot.rotvec_to_matrix(FOREARM * twist[:, None] * axis)
    locals_ = (
        np.swapaxes(collar, 1, 2) @ upper,
        np.swapaxes(upper, 1, 2) @ fore @ part,
        np.swapaxes(fore @ part, 1, 2) @ hand,
    )
    return {j: rot.matrix_to_rotvec(m) for j, m in zip(arm.joints, locals_, strict=True)}


def palm_frame(side: str, fingers: Array, facing: Array) -> Array:
    """World rotation (T, 3, 3) of a flat hand.

    Args:
        side: "left" or "right".
        fingers: Direction of the fingers, (T, 3) or (3,).
        facing: Normal of the palm, (T, 3) or (3,), made perpendicular to `fingers`.
    """
    left = 1.0 if side == "left" else -1.0
    along, facing = np.broadcast_arrays(np.atleast_2d(fingers), np.atleast_2d(facing))
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    facing = facing - np.sum(facing * along, axis=1, keepdims=True) * along
    facing = facing / np.linalg.norm(facing, axis=1, keepdims=True)
    # At rest left fingers point along x and right fingers along -x, with palms down.
    x, y = left * along, -facing
    return np.stack([x, y, rot.cross(x, y)], axis=-1)


def _bone(rest: Array, actual: Array, hinge: Array) -> Array:
    """Rotations (T, 3, 3) from a rest vector (3,) to `actual` (T, 3), with y toward `hinge`."""

    def frame(along: Array, across: Array) -> Array:
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        across = across - np.sum(across * along, axis=-1, keepdims=True) * along
        across = across / np.linalg.norm(across, axis=-1, keepdims=True)
        return np.stack([along, across, rot.cross(along, across)], axis=-1)

    return frame(actual, hinge) @ frame(rest, np.array([0.0, 1.0, 0.0])).T
