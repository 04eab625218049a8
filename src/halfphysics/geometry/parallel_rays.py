"""Crossings of parallel rays with triangles: exact intervals inside a closed surface.

Rays run along +z through the middles (i + 0.5, j + 0.5) of the cells of a unit grid.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def cells(low: Array, high: Array) -> tuple[Ints, Ints]:
    """All integer pairs (n, 2) within boxes low..high (m, 2), ends included; their boxes (n,)."""
    start = low.astype(np.int64)
    width, height = np.maximum(high.astype(np.int64) - start + 1, 0).T
    count = width * height
    owner = np.repeat(np.arange(len(count)), count)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    column, row = rank % width[owner], rank // width[owner]
    return owner, start[owner] + np.stack([column, row], axis=1)


def ray_key(cell: Ints) -> Ints:
    """One number per cell (n, 2), unique while indices stay under half a million."""
    return cell[:, 0] * (1 << 20) + cell[:, 1]


def crossings(
    vertices: Array, faces: Ints, window: tuple[Array, Array] | None = None
) -> tuple[Ints, Array, Ints]:
    """Where rays at (i + 0.5, j + 0.5) along +z cross faces: (i, j), z, +1 entering, -1 leaving.

    Two faces determine on which side of their common edge a ray passes by the same arithmetic, with
    opposite signs: a ray cannot pass between them or hit both. `window`: smallest and largest
    (i, j) of the rays, (2,) each; None: all.
    """
    flat = vertices[:, :2] - 0.5
    corners = flat[faces]
    low, high = np.ceil(corners.min(axis=1)), np.floor(corners.max(axis=1))
    if window is not None:
        low, high = np.maximum(low, window[0]), np.minimum(high, window[1])
    face, ray = cells(low, high)
    side = np.empty((3, len(face)))
    for k in range(3):
        a, b = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        start, end = flat[np.minimum(a, b)], flat[np.maximum(a, b)]
        along, across = (end - start)[face], ray - start[face]
        value = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
        # For both faces a ray on the edge is to the left of it, seen from the lower vertex.
        value = np.where(value == 0.0, np.finfo(np.float64).tiny, value)
        side[k] = np.where(a < b, 1.0, -1.0)[face] * value
    upward = np.asarray((side > 0.0).all(axis=0))
    hit = upward | (side < 0.0).all(axis=0)
    side, face = side[:, hit], face[hit]
    z = np.einsum("kn,nk->n", side / side.sum(axis=0), vertices[:, 2][faces[face]])
    return ray[hit], z, np.where(upward[hit], -1, 1)
