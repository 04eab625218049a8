"""The bones of the skeleton whose joint positions a file has.

A bone's length is the median over the frames. Its direction at rest is our body's, but for the
bones of pelvis and chest: the three of each are rigid, so their form is the mean over the frames in
axes that turn along, and it is turned to lie as our body's do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.formats.positions.first_guess import branch, unit_of
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS

Array = NDArray[np.float64]

BRANCHES = {
    JOINT_INDEX["pelvis"]: tuple(JOINT_INDEX[j] for j in ("left_hip", "right_hip", "spine1")),
    JOINT_INDEX["spine3"]: tuple(JOINT_INDEX[j] for j in ("neck", "left_collar", "right_collar")),
}
_LIMBS = tuple(
    JOINT_INDEX[f"{side}_{joint}"]
    for side in ("left", "right")
    for joint in ("knee", "ankle", "elbow", "wrist")
)
_LEGS = tuple(
    JOINT_INDEX[f"{side}_{joint}"] for side in ("left", "right") for joint in ("knee", "ankle")
)
#: Rounds in which the form of pelvis and chest is found: each turns the frames to the last mean.
_ROUNDS = 3


def bones_of(places: Array, rest: Array) -> Array:
    """Offset of every joint from its parent at rest (55, 3) [m]; NaN: the file has no such joint.

    Args:
        places: Joint positions (T, 55, 3) [m], NaN where the file has none.
        rest: Joints of our body at rest (55, 3) [m].
    """
    own = rest - rest[np.maximum(PARENTS, 0)]
    steps = places - places[:, np.maximum(PARENTS, 0)]
    bones = unit_of(own) * np.median(np.linalg.norm(steps, axis=2), axis=0)[:, None]
    bones[0] = np.nan
    for joint, ends in BRANCHES.items():
        form = np.array(rest)
        for _ in range(_ROUNDS):
            turn = rot.conjugate(branch(places, form, joint, ends))
            for end in ends:
                mean = rot.rotate(turn, places[:, end] - places[:, joint]).mean(axis=0)
                form[end] = form[joint] + mean
            # The mean frame is our body's: the form lies as our bones do.
            back = rot.conjugate(branch(form[None], rest, joint, ends))[0]
            for end in ends:
                form[end] = form[joint] + rot.rotate(back, form[end] - form[joint])
        for end in ends:
            bones[end] = form[end] - form[joint]
    return np.asarray(bones)


def leg(places: Array) -> float:
    """Median length of the legs from hip to ankle, of positions (T, 55, 3)."""
    steps = places[:, _LEGS] - places[:, PARENTS[list(_LEGS)]]
    return float(np.median(np.linalg.norm(steps, axis=2).sum(axis=1) / 2.0))


def facing(places: Array) -> float:
    """Cosine between where hips and spine face and where the toes point: a median.

    Near -1: a mirror image, or left and right in each other's place.
    """
    left, right, spine = (places[:, JOINT_INDEX[j]] for j in ("left_hip", "right_hip", "spine3"))
    ahead = unit_of(np.cross(left - right, spine - 0.5 * (left + right)))
    toes = [
        places[:, JOINT_INDEX[f"{side}_foot"]] - places[:, JOINT_INDEX[f"{side}_ankle"]]
        for side in ("left", "right")
    ]
    return float(np.median(np.einsum("ti,ti->t", ahead, unit_of(toes[0] + toes[1]))))


def change(places: Array) -> float:
    """By how much the bones of arms and legs change their lengths, relative: a median."""
    lengths = np.linalg.norm(places[:, _LIMBS] - places[:, PARENTS[list(_LIMBS)]], axis=2)
    middle = np.median(lengths, axis=0)
    spread = np.percentile(lengths, 90, axis=0) - np.percentile(lengths, 10, axis=0)
    return float(np.median(spread / np.maximum(middle, 1e-9)))
