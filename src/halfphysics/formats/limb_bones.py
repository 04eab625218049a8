"""The bones and hinges of limbs and neck, for readers that turn bones to where a file has them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX

_SIDES = {"left": 1.0, "right": -1.0}

#: Joint of the first 22 with one bone below it -> the joint at the bone's end.
BONES = {
    JOINT_INDEX[f"{side}_{joint}"]: JOINT_INDEX[f"{side}_{end}"]
    for side in _SIDES
    for joint, end in (
        ("hip", "knee"),
        ("knee", "ankle"),
        ("ankle", "foot"),
        ("collar", "shoulder"),
        ("shoulder", "elbow"),
        ("elbow", "wrist"),
    )
} | {JOINT_INDEX["neck"]: JOINT_INDEX["head"]}


class Hinge(NamedTuple):
    """A knee or an elbow.

    Attributes:
        upper: The joint at the upper end of the bone above it.
        joint: The hinge itself.
        axis: About which it flexes, in SMPL-X's rest axes, by positive angles.
    """

    upper: int
    joint: int
    axis: NDArray[np.float64]


HINGES = tuple(
    Hinge(JOINT_INDEX[f"{side}_{upper}"], JOINT_INDEX[f"{side}_{joint}"], np.array(axis))
    for side, sign in _SIDES.items()
    for upper, joint, axis in (
        ("hip", "knee", (1.0, 0.0, 0.0)),
        ("shoulder", "elbow", (0.0, -sign, 0.0)),
    )
)
