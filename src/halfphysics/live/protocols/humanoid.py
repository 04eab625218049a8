"""Unity's `HumanBodyBones`: 55 bones that are the 55 SMPL-X joints under other names.

Their hierarchy is Unity's: a model may lack bones, and then the next one hangs on the nearest that
is there (a neck on the chest, if there is no upper chest).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from halfphysics.live.protocols.chain import Chain
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS

_MIDDLE = {
    "Hips": "pelvis",
    "Spine": "spine1",
    "Chest": "spine2",
    "UpperChest": "spine3",
    "Neck": "neck",
    "Head": "head",
    "Jaw": "jaw",
}
_SIDED = {
    "UpperLeg": "hip",
    "LowerLeg": "knee",
    "Foot": "ankle",
    "Toes": "foot",
    "Shoulder": "collar",
    "UpperArm": "shoulder",
    "LowerArm": "elbow",
    "Hand": "wrist",
    "Eye": "eye_smplhf",
}
_FINGERS = {
    "Thumb": "thumb",
    "Index": "index",
    "Middle": "middle",
    "Ring": "ring",
    "Little": "pinky",
}
_PHALANGES = ("Proximal", "Intermediate", "Distal")


def _joints() -> dict[str, int]:
    names = dict(_MIDDLE)
    for side in ("Left", "Right"):
        low = side.lower()
        names |= {f"{side}{bone}": f"{low}_{joint}" for bone, joint in _SIDED.items()}
        names |= {
            f"{side}{finger}{phalanx}": f"{low}_{joint}{k}"
            for finger, joint in _FINGERS.items()
            for k, phalanx in enumerate(_PHALANGES, 1)
        }
    by_joint = {JOINT_INDEX[joint]: bone for bone, joint in names.items()}
    return {by_joint[joint]: joint for joint in sorted(by_joint)}


#: Bone -> SMPL-X joint, in the order of the joints: bone i turns joint i.
JOINT_OF: Mapping[str, int] = MappingProxyType(_joints())
#: The bones in that order.
BONES: tuple[str, ...] = tuple(JOINT_OF)
#: The same by names in lower case; VRM 1 names the thumb's bones otherwise.
INDEX_OF: Mapping[str, int] = MappingProxyType({name.lower(): i for name, i in JOINT_OF.items()})


#: Their hierarchy.
CHAIN = Chain(PARENTS.tolist())
