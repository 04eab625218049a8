"""How people bend their joints: mean and spread of every joint's rotation, for what joint positions
leave open.

The numbers are axis-angle components in SMPL-X's rest axes (x to the person's left, y up, z ahead),
of a person in a T-pose: knees flex about +x, elbows about -y (left) and +y (right), forearms and
upper arms twist about x, thighs and shanks about y. They decide only what positions do not: with a
spread of 0.1 rad a joint still turns by 2 rad where positions ask for it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS

Array = NDArray[np.float64]

#: Joint (without its side) -> spread about x, y, z [rad].
_SPREADS = {
    "hip": (0.8, 0.35, 0.5),
    "knee": (0.9, 0.12, 0.08),
    "ankle": (0.4, 0.2, 0.2),
    "foot": (0.4, 0.05, 0.05),
    "spine1": (0.35, 0.25, 0.25),
    "spine2": (0.25, 0.2, 0.2),
    "spine3": (0.2, 0.2, 0.2),
    "neck": (0.4, 0.4, 0.3),
    "head": (0.4, 0.4, 0.3),
    "collar": (0.15, 0.25, 0.25),
    "shoulder": (0.35, 0.8, 0.9),
    "elbow": (0.4, 0.9, 0.12),
    "wrist": (0.3, 0.4, 0.6),
}
#: All others: fingers.
_OTHERS = (0.3, 0.3, 0.6)
#: Joint of the left side -> mean rotation [rad]: relaxed knees and elbows are a little bent.
_MEANS = {"knee": (0.3, 0.0, 0.0), "elbow": (0.0, -0.4, 0.0), "shoulder": (0.0, -0.2, -0.8)}


def _kind(joint: int) -> str:
    return JOINT_NAMES[joint].removeprefix("left_").removeprefix("right_")


def _table() -> tuple[Array, Array]:
    means, weights = np.zeros((N_JOINTS, 3)), np.zeros((N_JOINTS, 3))
    for joint in range(N_JOINTS):
        weights[joint] = np.array(_SPREADS.get(_kind(joint), _OTHERS)) ** -2.0
        mean = np.array(_MEANS.get(_kind(joint), (0.0, 0.0, 0.0)))
        # A mirror image about x = 0 has the opposite turns about y and z.
        mirrored = JOINT_NAMES[joint].startswith("right_")
        means[joint] = mean * [1.0, -1.0, -1.0] if mirrored else mean
    weights[JOINT_INDEX["pelvis"]] = 0.0
    return means, weights


#: Mean rotations (55, 3) [rad], and weights (55, 3) [1/rad^2]: one over the squared spreads.
MEANS, WEIGHTS = _table()
