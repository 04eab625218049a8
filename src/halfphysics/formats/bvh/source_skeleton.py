"""The skeleton of a BVH file: its joints in space and the SMPL-X joints they match."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.euler import from_angles
from halfphysics.errors import FileError
from halfphysics.formats.bvh.hierarchy import CHANNELS
from halfphysics.formats.bvh.skeleton_maps import match_joints
from halfphysics.formats.bvh.text import Bvh
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
        bvh: The file.
        joints: SMPL-X joint -> joint of the file, with the pelvis, without the spine.
        spine: Joints of the file after the pelvis up to the chest, from which arms branch off.
    """

    bvh: Bvh
    joints: dict[int, int]
    spine: tuple[int, ...]

    @staticmethod
    def of(where: str, bvh: Bvh) -> SourceSkeleton:
        """Find a person's joints by their names.

        Raises:
            FileError: Legs or arms are not found, or have no length.
        """
        joints = match_joints(bvh.names, bvh.parents)
        missing = [JOINT_NAMES[j] for j in NEEDED if j not in joints]
        if missing:
            shown = ", ".join(bvh.names[:40]) + (", ..." if len(bvh.names) > 40 else "")
            raise FileError(
                f"{where}: no joint is known as {', '.join(missing)}. Found joints {shown}; "
                "expected names as Mixamo, CMU, Rokoko, LAFAN1, Biped, Unreal or SMPL have them. "
                "Rename the joints"
            )
        paths = {j: _path(bvh.parents, joint) for j, joint in joints.items()}
        pelvis = _meeting(*(paths[JOINT_INDEX[f"{s}_hip"]] for s in ("left", "right")))
        chest = _meeting(*(paths[JOINT_INDEX[f"{s}_shoulder"]] for s in ("left", "right")))
        if pelvis is None or chest is None:
            raise FileError(
                f"{where}: a leg hangs on the other leg, or an arm on the other arm; expected legs "
                "that meet at the pelvis and arms that meet at the chest"
            )
        below = _path(bvh.parents, pelvis)
        spine = tuple(joint for joint in _path(bvh.parents, chest) if joint not in below)
        joints = {j: _last_in_place(bvh, joints, j) if j in LIMBS else joints[j] for j in joints}
        source = SourceSkeleton(bvh, {0: pelvis, **joints}, spine)
        for joint, then in BONES:
            way = source.rest[joints[joint]] - source.rest[joints[then]]
            if np.linalg.norm(way) < _NO_LENGTH:
                raise FileError(
                    f"{where}: the bone from {JOINT_NAMES[joint]} to {JOINT_NAMES[then]} has no "
                    "length, expected OFFSETs that are the bones of a person"
                )
        return source

    @property
    def chest(self) -> int:
        """The joint of the file from which the arms branch off."""
        return self.spine[-1] if self.spine else self.joints[0]

    @cached_property
    def offsets(self) -> Array:
        """Positions in the parents' frames (J, 3); without an offset, the mean position."""
        offsets = self.bvh.offsets.copy()
        for joint, start in enumerate(self.bvh.starts):
            if joint and not offsets[joint].any():
                for axis, column in self._columns(joint, start, "position"):
                    offsets[joint, axis] = self.bvh.values[:, column].mean()
        return offsets

    @cached_property
    def rest(self) -> Array:
        """Positions of the joints (J, 3) for zero rotations, with the root at the origin."""
        rest = np.zeros_like(self.offsets)
        for joint, parent in enumerate(self.bvh.parents):
            if parent >= 0:
                rest[joint] = rest[parent] + self.offsets[joint]
        return rest

    @cached_property
    def leg(self) -> float:
        """Length from hip through knee to ankle, mean of both legs."""
        lengths = []
        for side in ("left", "right"):
            chain = [self.joints[JOINT_INDEX[f"{side}_{j}"]] for j in ("hip", "knee", "ankle")]
            lengths.append(np.linalg.norm(np.diff(self.rest[chain], axis=0), axis=1).sum())
        return float(np.mean(lengths))

    def frames(self, rows: slice) -> tuple[Array, Array]:
        """World frames of the joints in the rows of the file.

        Returns:
            Positions (T, J, 3) and quaternions (T, J, 4), world from joint, in the file's axes.
        """
        bvh = self.bvh
        values = bvh.values[rows]
        positions = np.zeros((len(values), len(bvh.names), 3))
        quaternions = np.zeros((len(values), len(bvh.names), 4))
        for joint, (parent, start) in enumerate(zip(bvh.parents, bvh.starts, strict=True)):
            turns = self._columns(joint, start, "rotation")
            angles = np.radians(values[:, [column for _, column in turns]])
            local = from_angles([axis for axis, _ in turns], angles)
            place = np.tile(bvh.offsets[joint], (len(values), 1))
            moves = self._columns(joint, start, "position")
            if moves:
                axes = [axis for axis, _ in moves]
                moved = values[:, [column for _, column in moves]]
                place[:, axes] = moved + (place[:, axes] if self._is_added(joint, moves) else 0.0)
            if parent < 0:
                positions[:, joint], quaternions[:, joint] = place, local
            else:
                positions[:, joint] = positions[:, parent] + rot.rotate(
                    quaternions[:, parent], place
                )
                quaternions[:, joint] = rot.multiply(quaternions[:, parent], local)
        return positions, quaternions

    def _columns(self, joint: int, start: np.intp, kind: str) -> list[tuple[int, int]]:
        """(axis, column) of the channels of a kind, in the file's order."""
        return [
            (CHANNELS.index(name) % 3, int(start) + k)
            for k, name in enumerate(self.bvh.channels[joint])
            if name.endswith(kind)
        ]

    def _is_added(self, joint: int, moves: list[tuple[int, int]]) -> bool:
        """Whether the position channels are added to the offset.

        They replace it, as in Blender and in files with the root's position in both, except for a
        joint below the root that stays closer to its offset if they are added.
        """
        if self.bvh.parents[joint] < 0:
            return False
        mean = self.bvh.values[:, [column for _, column in moves]].mean(axis=0)
        offset = self.bvh.offsets[joint][[axis for axis, _ in moves]]
        return bool(np.linalg.norm(mean) < np.linalg.norm(mean - offset))


def _last_in_place(bvh: Bvh, joints: dict[int, int], joint: int) -> int:
    """The last of several joints in one place, from which the bone starts.

    CMU's wrist twists in LeftHand and bends in LeftFingerBase, without an offset between them.
    """
    own, taken = joints[joint], set(joints.values())
    thumbs = {joints[j] for j in joints if JOINT_NAMES[j].endswith("thumb1")}
    while True:
        below = [j for j in taken - thumbs if own != j and own in _path(bvh.parents, j)]
        for child, parent in enumerate(bvh.parents):
            if parent != own or child in taken or bvh.offsets[child].any():
                continue
            leaf = child not in bvh.parents
            if (not leaf) if not below else all(child in _path(bvh.parents, j) for j in below):
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
