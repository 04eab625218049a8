"""Reaching: one hand leaves its motion, moves to a target, and returns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.joint_ranges import JointRanges, from_swing_twist, swing_twist
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting import arms

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]


def between(start: Array, end: Array, share: Array) -> Array:
    """Rotations (T, 3) at the fraction `share` (T,) between `start` and `end` (T, 3)."""
    first = rot.exp(start)
    way = rot.log(rot.multiply(rot.conjugate(first), rot.exp(end)))
    return rot.log(rot.multiply(first, rot.exp(share[:, None] * way)))


def bent_between(body: Body, joint: int, start: Array, end: Array, share: Array) -> Array:
    """As `between`, angle by angle (twist, flexion, abduction): who has both ends within the
    joint's ranges, is within them on the way, too.
    """
    axes = JointRanges.of(body).axes[joint]
    first, last = (swing_twist(rot.exp(turn), axes) for turn in (start, end))
    return from_swing_twist(first + share[:, None] * (last - first), axes)


def palm_depth(body: Body, side: str) -> float:
    """Distance of the palm from the wrist joint, along the palm's normal [m]."""
    wrist = JOINT_INDEX[f"{side}_wrist"]
    own = body.main_joint == wrist
    return float(np.asarray(body.rest_joints)[wrist, 1] - body.rest_vertices[own, 1].min())


def knuckle_ahead(body: Body, side: str) -> float:
    """Distance of the middle finger's knuckle from the wrist [m]."""
    joints = np.asarray(body.rest_joints)
    knuckle, wrist = (JOINT_INDEX[f"{side}_{name}"] for name in ("middle1", "wrist"))
    return float(np.linalg.norm(joints[knuckle] - joints[wrist]))


def reach(
    body: Body,
    base: Motion,
    side: str,
    wrist: Array,
    hand: Array,
    share: Array,
    *,
    pole: ArrayLike,
    fingers: Mapping[int, Array],
) -> Motion:
    """A motion with one hand moved to a target.

    Args:
        body: The person's body.
        base: The motion of all other joints, T frames, z up.
        side: "left" or "right".
        wrist: Target position of the wrist [m], (T, 3).
        hand: Target world rotation of the hand (T, 3, 3), as from `arms.palm_frame`.
        share: Weight of the target at each frame, 0 (as in `base`) to 1, (T,).
        pole: Direction of the elbow, (3,) or (T, 3).
        fingers: Rotations of the finger joints, joint index -> axis-angle (T, 3).
    """
    positions, quaternions = body.joint_frames(base)
    arm = arms.arm_of(body, side)
    collar = rot.to_matrix(quaternions[:, arm.collar])
    held = arms.solve(
        arm, collar, positions[:, arm.joints[0]], wrist, hand, np.asarray(pole, dtype=np.float64)
    )
    rotations = np.array(base.rotations)
    for joint, turn in (held | dict(fingers)).items():
        rotations[:, joint] = bent_between(body, joint, rotations[:, joint], turn, share)
    return base.with_frames(base.translation, rotations)
