"""The skeleton: 55 SMPL-X joints, their names, parents and groups."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

_FINGERS = ("index", "middle", "pinky", "ring", "thumb")

#: The 55 SMPL-X joint names, in SMPL-X order (as in the `smplx` package).
JOINT_NAMES: tuple[str, ...] = (
    *("pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2"),
    *("left_ankle", "right_ankle", "spine3", "left_foot", "right_foot", "neck"),
    *("left_collar", "right_collar", "head", "left_shoulder", "right_shoulder"),
    *("left_elbow", "right_elbow", "left_wrist", "right_wrist"),
    *("jaw", "left_eye_smplhf", "right_eye_smplhf"),
    *(f"{side}_{f}{k}" for side in ("left", "right") for f in _FINGERS for k in (1, 2, 3)),
)

#: Number of joints, and of rigid parts: one per joint.
N_JOINTS = len(JOINT_NAMES)

#: Name -> index into `JOINT_NAMES`.
JOINT_INDEX = MappingProxyType({name: i for i, name in enumerate(JOINT_NAMES)})


def _parents() -> np.ndarray:
    parents = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 15, 15, 15]
    for wrist in (JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]):
        for _ in _FINGERS:
            first = len(parents)
            parents += [wrist, first, first + 1]
    array = np.array(parents, dtype=np.int32)
    array.setflags(write=False)
    return array


#: Parent of every joint, shape (55,); -1 for the pelvis. Parents precede children.
PARENTS: np.ndarray = _parents()

#: Joint -> its mirror image (55,): left and right change places.
MIRRORED: np.ndarray = np.array(
    [
        JOINT_INDEX[
            name.replace("left_", "right_") if "left_" in name else name.replace("right_", "left_")
        ]
        for name in JOINT_NAMES
    ]
)
MIRRORED.setflags(write=False)

#: Indices of the joints in the layouts that data files use, in the file's own order.
BODY_JOINTS = tuple(range(1, 22))
FACE_JOINTS = (22, 23, 24)
LEFT_HAND_JOINTS = tuple(range(25, 40))
RIGHT_HAND_JOINTS = tuple(range(40, 55))
#: SMPL-H: pelvis, 21 body joints, 15 left and 15 right finger joints (52).
SMPLH_JOINTS = (0, *BODY_JOINTS, *LEFT_HAND_JOINTS, *RIGHT_HAND_JOINTS)
#: SMPL: pelvis and 21 body joints (its joints 22 and 23 are rigid hands and have no match).
SMPL_JOINTS = (0, *BODY_JOINTS)
