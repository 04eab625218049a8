"""Bones that hang on each other: rotations and positions in parents' frames and in one frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]


class Chain:
    """A tree of bones.

    Args:
        parents: Of each bone (n,), -1 for the first; parents precede children.
    """

    def __init__(self, parents: Sequence[int]) -> None:
        self.parents = np.asarray(parents, dtype=np.intp)
        self._above = np.maximum(self.parents, 0)
        depth = np.zeros(len(self.parents), dtype=int)
        for bone, parent in enumerate(self.parents.tolist()):
            depth[bone] = depth[parent] + 1 if parent >= 0 else 0
        self._levels = [np.flatnonzero(depth == level) for level in range(1, depth.max() + 1)]

    def world_rotations(self, local: Array) -> Array:
        """Rotations in the root's axes (n, 4) of those in the parents' frames (n, 4)."""
        world = np.array(local)
        for level in self._levels:
            world[level] = rot.multiply(world[self.parents[level]], local[level])
        return world

    def local_rotations(self, world: Array) -> Array:
        """Rotations in the parents' frames (n, 4) of those in the root's axes (n, 4)."""
        local = rot.multiply(rot.conjugate(world[self._above]), world)
        local[self.parents < 0] = world[self.parents < 0]
        return local

    def world_positions(self, world: Array, offsets: Array) -> Array:
        """Positions in the root's axes (n, 3) of bones at `offsets` (n, 3) from their parents."""
        positions = np.array(offsets)
        for level in self._levels:
            above = self.parents[level]
            positions[level] = positions[above] + rot.rotate(world[above], offsets[level])
        return positions

    def offsets(self, positions: Array) -> Array:
        """Each position (n, 3) seen from its parent's; the first stays."""
        seen = positions - positions[self._above]
        seen[self.parents < 0] = positions[self.parents < 0]
        return seen
