"""Feet put elsewhere by the legs: hip, knee and ankle follow, and where a leg is too short for it
the pelvis comes down.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from halfphysics.adaptation import arm_pose
from halfphysics.adaptation.feet import Foot, in_reach, reach_of
from halfphysics.base import rotations as rot

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SIDES = ("left", "right")
#: The pelvis comes down by no more than this [m]: beyond, the foot stays short of its place.
MOST_DOWN = 0.03
#: It comes and goes over this [s].
_EASED = 0.13
#: What running sums leave of 0 is less than this [m].
_ROUNDING = 1e-9
#: How willingly hip, knee and ankle turn (axis-angle components of each); the knee is a hinge.
_WILLING = np.array([1.0, 0.3, 1.0, 1.0, 0.02, 0.02, 0.6, 0.6, 0.6])


def feet_moved(motion: Motion, body: Body, shift: Array, turn: Array, stands: Mask) -> Motion:
    """The motion with its ankles shifted and turned.

    Args:
        motion: The motion, T frames.
        body: The person's body.
        shift: Of the left and the right ankle (T, 2, 3) [m].
        turn: Rotation of each foot, world from ankle (T, 2, 4).
        stands: Whether each foot has to reach its place (T, 2): the pelvis comes down for it.

    Returns:
        The motion; frames in which no foot is moved are as they were. A foot that is out of reach
        is put as near as its leg goes.
    """
    position, quaternion = body.joint_frames(motion)
    feet = [(k, foot) for k, side in enumerate(SIDES) if (foot := Foot.of(body, side)) is not None]
    goal = {k: position[:, foot.limb[2]] + shift[:, k] for k, foot in feet}
    down = np.zeros(len(motion))
    for k, foot in feet:
        lacks = _lacking(position[:, foot.limb[0]] - goal[k], reach_of(body, foot, position))
        down = np.maximum(down, np.where(stands[:, k], lacks, 0.0))
    root = np.outer(_eased(down, motion.fps), [0.0, 0.0, 1.0])
    lower = motion.with_frames(motion.translation - root, motion.rotations)
    rotations = np.array(motion.rotations)
    for k, foot in feet:
        turned = (turn[:, k] != quaternion[:, foot.limb[2]]).any(axis=1)
        frames = np.flatnonzero(turned | shift[:, k].any(axis=1) | root.any(axis=1))
        if not len(frames):
            continue
        # From the hip where it was: the leg may be as long as it was before the pelvis came down.
        to = in_reach(body, foot, position, goal[k] + root)[frames] - root[frames]
        rotations[np.ix_(frames, np.array(foot.limb))] = arm_pose.moved(
            lower, body, foot, frames, to, rot.to_matrix(turn[frames, k]), _WILLING
        )
    return lower.with_frames(lower.translation, rotations)


def _eased(down: Array, fps: float) -> Array:
    """At least as far down in every frame (T,) [m], and there without a jerk."""
    width = 2 * round(0.5 * _EASED * fps) + 1
    most = maximum_filter1d(down, width, mode="nearest")
    result: Array = uniform_filter1d(most, width, mode="nearest")
    return np.where(result > _ROUNDING, result, 0.0)


def _lacking(away: Array, reach: Array) -> Array:
    """How far the hip has to come down (T,) [m], by its place seen from the ankle's goal (T, 3)."""
    under = reach**2 - (away[:, :2] ** 2).sum(axis=1)
    lacks = away[:, 2] - np.sqrt(np.maximum(under, 0.0))
    result: Array = np.clip(np.where(under > 0.0, lacks, 0.0), 0.0, MOST_DOWN)
    return result
