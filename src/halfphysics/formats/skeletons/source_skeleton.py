"""The skeleton of a file and the SMPL-X joints that its joints match."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton
from halfphysics.formats.skeletons.skeleton_maps import match_joints
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES

Array = NDArray[np.float64]

#: The joints that every human skeleton must have.
NEEDED = tuple(
    JOINT_INDEX[f"{side}_{joint}"]
    for joint in ("hip", "knee", "ankle", "shoulder", "elbow")
    for side in ("left", "right")
)
#: Bones of limbs that must have a length.
BONES = tuple(
    (JOINT_INDEX[f"{side}_{joint}"], JOINT_INDEX[f"{side}_{then}"])
    for joint, then in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"))
    for side in ("left", "right")
)
_NO_LENGTH = 1e-6  # units of the file: metres or less
#: Joints that a file may split into several in one place, one for each axis.
LIMBS = tuple(
    JOINT_INDEX[f"{side}_{joint}"]
    for joint in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
    for side in ("left", "right")
)
#: Joints with an offset below this fraction of the leg length are in one place.
SAME_PLACE = 1e-4


@dataclass(frozen=True, eq=False)
class SourceSkeleton:
    """Joints of a file, in its unit and axes.

    Attributes:
        skeleton: All joints of the file.
        joints: SMPL-X joint -> joint of the file, with the pelvis, without the spine.
        spine: Joints of the file after the pelvis up to the chest, from which arms branch off.
    """

    skeleton: AnimatedSkeleton
    joints: dict[int, int]
    spine: tuple[int, ...]

    @staticmethod
    def of(where: str, skeleton: AnimatedSkeleton) -> SourceSkeleton:
        """Find a person's joints by their names.

        Raises:
            FileError: Legs or arms are not found, or have no length.
        """
        joints = match_joints(skeleton.names, skeleton.parents)
        missing = [JOINT_NAMES[j] for j in NEEDED if j not in joints]
        if missing:
            shown = ", ".join(skeleton.names[:40]) + (", ..." if len(skeleton.names) > 40 else "")
            raise FileError(
                f"{where}: no joint is known as {', '.join(missing)}. Found joints {shown}; "
                "expected names as Mixamo, CMU, Rokoko, LAFAN1, Biped, Unreal or SMPL have them. "
                "Rename the joints"
            )
        paths = {j: _path(skeleton.parents, joint) for j, joint in joints.items()}
        pelvis = _meeting(*(paths[JOINT_INDEX[f"{s}_hip"]] for s in ("left", "right")))
        chest = _meeting(*(paths[JOINT_INDEX[f"{s}_shoulder"]] for s in ("left", "right")))
        if pelvis is None or chest is None:
            raise FileError(
                f"{where}: a leg hangs on the other leg, or an arm on the other arm; expected legs "
                "that meet at the pelvis and arms that meet at the chest"
            )
        below = _path(skeleton.parents, pelvis)
        spine = tuple(joint for joint in _path(skeleton.parents, chest) if joint not in below)
        joints = {
            j: _last_in_place(skeleton, joints, j) if j in LIMBS else joints[j] for j in joints
        }
        source = SourceSkeleton(skeleton, {0: pelvis, **joints}, spine)
        for joint, then in BONES:
            way = source.rest[joints[joint]] - source.rest[joints[then]]
            if np.linalg.norm(way) < _NO_LENGTH:
                raise FileError(
                    f"{where}: the bone from {JOINT_NAMES[joint]} to {JOINT_NAMES[then]} has no "
                    "length, expected offsets that are the bones of a person"
                )
        return source

    @property
    def chest(self) -> int:
        """The joint of the file from which the arms branch off."""
        return self.spine[-1] if self.spine else self.joints[0]

    @cached_property
    def rest(self) -> Array:
        """Positions of the joints (J, 3) for zero rotations, with the root at the origin."""
        rest = np.zeros_like(self.skeleton.offsets)
        for joint, parent in enumerate(self.skeleton.parents):
            if parent >= 0:
                rest[joint] = rest[parent] + self.skeleton.offsets[joint]
        return rest

    @cached_property
    def leg(self) -> float:
        """Length from hip through knee to ankle, mean of both legs."""
        lengths = []
        for side in ("left", "right"):
            chain = [self.joints[JOINT_INDEX[f"{side}_{j}"]] for j in ("hip", "knee", "ankle")]
            lengths.append(np.linalg.norm(np.diff(self.rest[chain], axis=0), axis=1).sum())
        return float(np.mean(lengths))


def _last_in_place(skeleton: AnimatedSkeleton, joints: dict[int, int], joint: int) -> int:
    """The last of several joints in one place, from which the bone starts.

    CMU's wrist twists in LeftHand and bends in LeftFingerBase, without an offset between them.
    """
    own, taken = joints[joint], set(joints.values())
    thumbs = {joints[j] for j in joints if JOINT_NAMES[j].endswith("thumb1")}
    while True:
        below = [j for j in taken - thumbs if own != j and own in _path(skeleton.parents, j)]
        for child, parent in enumerate(skeleton.parents):
            if parent != own or child in taken or skeleton.offsets[child].any():
                continue
            leaf = child not in skeleton.parents
            if (not leaf) if not below else all(child in _path(skeleton.parents, j) for j in below):
                own = child
                break
        else:
            return own


def _path(parents: tuple[int, ...], joint: int) -> list[int]:
    """The joints from the root to a joint."""
    path = []
    while joint >= 0:
        path.append(joint)
        joint = parents[joint]
    return path[::-1]


def _meeting(left: list[int], right: list[int]) -> int | None:
    """The last joint that both paths share; None: one of them ends there."""
    common = [a for a, b in zip(left, right, strict=False) if a == b]
    return common[-1] if common and common[-1] not in (left[-1], right[-1]) else None
