"""Spans: intervals of parallel rays, such as those inside a solid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.parallel_rays import ray_key
from halfphysics.metrics.argument_checks import Array

Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Spans:
    """Intervals of rays along z: ray (n, 2), z at the bottom (n,) and at the top (n,)."""

    ray: Ints
    bottom: Array
    top: Array

    @classmethod
    def of_crossings(cls, ray: Ints, z: Array, sign: Ints) -> Spans:
        """The intervals inside a closed surface, where its winding number is over 0.

        Rays (n, 2) cross it at z (n,), sign +1 entering, -1 leaving. A ray with fewer exits than
        entries ran along an edge of a surface that is not closed: it is dropped.
        """
        key = ray_key(ray)
        order = np.lexsort((z, key))
        key, z, sign = key[order], z[order], sign[order]
        group = np.unique(key, return_inverse=True)[1].reshape(-1)
        whole = np.bincount(group, weights=sign)[group] == 0.0 if len(group) else key > 0
        ray, z, depth = ray[order][whole], z[whole], np.cumsum(sign[whole])
        before = np.concatenate([[0], depth[:-1]]) if len(depth) else depth
        enters, leaves = (before <= 0) & (depth > 0), (before > 0) & (depth <= 0)
        return cls(ray[enters], z[enters], z[leaves])

    @classmethod
    def union(cls, each: list[Spans]) -> Spans:
        """The intervals that are in any of some spans."""
        ray = np.concatenate([s.ray for s in each] * 2)
        z = np.concatenate([s.bottom for s in each] + [s.top for s in each])
        sign = np.repeat([1, -1], len(ray) // 2)
        return cls.of_crossings(ray, z, sign)

    def common(self, other: Spans) -> tuple[Ints, Array]:
        """Rays (k, 2) and lengths (k,) of the intersections; own intervals must not overlap."""
        ray = np.concatenate([self.ray, self.ray, other.ray, other.ray])
        z = np.concatenate([self.bottom, self.top, other.bottom, other.top])
        mine, its = len(self.ray), len(other.ray)
        steps = np.zeros((len(ray), 2), dtype=np.int64)
        steps[:, 0] = np.repeat([1, -1, 0, 0], [mine, mine, its, its])
        steps[:, 1] = np.repeat([0, 0, 1, -1], [mine, mine, its, its])
        key = ray_key(ray)
        order = np.lexsort((z, key))
        ray, z, key = ray[order], z[order], key[order]
        depth = np.cumsum(steps[order], axis=0)[:-1]
        both = (depth[:, 0] > 0) & (depth[:, 1] > 0)
        both &= key[1:] == key[:-1]
        return ray[:-1][both], (z[1:] - z[:-1])[both]
