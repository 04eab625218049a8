"""The joints of a BVH file in space, from the values of its channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.euler import from_angles
from halfphysics.formats.bvh.hierarchy import CHANNELS
from halfphysics.formats.bvh.text import Bvh
from halfphysics.formats.skeletons.animated_skeleton import AnimatedSkeleton
from halfphysics.formats.skeletons.soma import is_soma

Array = NDArray[np.float64]


def animated(bvh: Bvh, rows: slice) -> AnimatedSkeleton:
    """The skeleton of a file over the frames `rows`."""
    positions, quaternions = _frames(bvh, bvh.values[rows])
    return AnimatedSkeleton(
        names=bvh.names,
        parents=bvh.parents,
        offsets=_offsets(bvh),
        ends=bvh.ends,
        positions=positions,
        quaternions=quaternions,
    )


def _offsets(bvh: Bvh) -> Array:
    """Positions in the parents' frames (J, 3); without an offset, the mean position."""
    offsets = bvh.offsets.copy()
    for joint in range(1, len(offsets)):
        if not offsets[joint].any():
            for axis, column in _columns(bvh, joint, "position"):
                offsets[joint, axis] = bvh.values[:, column].mean()
    return offsets


def _frames(bvh: Bvh, values: Array) -> tuple[Array, Array]:
    """Positions (T, J, 3) and quaternions (T, J, 4), world from joint, in the file's axes."""
    positions = np.zeros((len(values), len(bvh.names), 3))
    quaternions = np.zeros((len(values), len(bvh.names), 4))
    for joint, parent in enumerate(bvh.parents):
        turns = _columns(bvh, joint, "rotation")
        angles = np.radians(values[:, [column for _, column in turns]])
        local = from_angles([axis for axis, _ in turns], angles)
        place = np.tile(bvh.offsets[joint], (len(values), 1))
        moves = _columns(bvh, joint, "position")
        if moves:
            axes = [axis for axis, _ in moves]
            moved = values[:, [column for _, column in moves]]
            place[:, axes] = moved + (place[:, axes] if _is_added(bvh, joint, moves) else 0.0)
        if parent < 0:
            positions[:, joint], quaternions[:, joint] = place, local
        else:
            above = quaternions[:, parent]
            positions[:, joint] = positions[:, parent] + rot.rotate(above, place)
            quaternions[:, joint] = rot.multiply(above, local)
    return positions, quaternions


def _columns(bvh: Bvh, joint: int, kind: str) -> list[tuple[int, int]]:
    """(axis, column) of the channels of a kind, in the file's order."""
    start = int(bvh.starts[joint])
    return [
        (CHANNELS.index(name) % 3, start + k)
        for k, name in enumerate(bvh.channels[joint])
        if name.endswith(kind)
    ]


def _is_added(bvh: Bvh, joint: int, moves: list[tuple[int, int]]) -> bool:
    """Whether the position channels are added to the offset.

    They replace it, as in Blender and in files with the root's position in both, except for a joint
    below the root that stays closer to its offset if they are added. Kimodo puts the hips of SOMA,
    which may lie, below a root and gives them an offset of 1 m that they replace.
    """
    if bvh.parents[joint] < 0 or is_soma(bvh.names):
        return False
    mean = bvh.values[:, [column for _, column in moves]].mean(axis=0)
    offset = bvh.offsets[joint][[axis for axis, _ in moves]]
    return bool(np.linalg.norm(mean) < np.linalg.norm(mean - offset))
