"""`geometry.mesh_queries` in plain numpy: every point against every triangle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int32]

_CHUNK = 2_000_000  # point-triangle pairs at a time


def winding_reference(points: ArrayLike, vertices: ArrayLike, faces: ArrayLike) -> Array:
    """Generalised winding numbers (n,), every triangle's solid angle summed, in numpy."""
    p, v = np.asarray(points, np.float64), np.asarray(vertices, np.float64)
    corners = v[np.asarray(faces)]
    result = np.empty(len(p))
    step = max(1, _CHUNK // max(1, len(corners)))
    for i in range(0, len(p), step):
        a, b, c = np.moveaxis(corners[None] - p[i : i + step, None, None], 2, 0)
        la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
        ab, bc, ca = (np.einsum("...i,...i", x, y) for x, y in ((a, b), (b, c), (c, a)))
        volume = np.einsum("...i,...i", a, np.cross(b, c))
        angle = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
        result[i : i + step] = angle.sum(axis=1) / (4.0 * np.pi)
    return result


def closest_reference(
    points: ArrayLike, vertices: ArrayLike, faces: ArrayLike
) -> tuple[Array, Indices, Array]:
    """As `MeshQuery.closest`, by trying every triangle in numpy.

    The closest point is the foot of the perpendicular where that lies in the triangle, else
    the nearest point of the three edges.
    """
    p, v = np.asarray(points, np.float64), np.asarray(vertices, np.float64)
    corners = v[np.asarray(faces)]
    distance, face, closest = np.empty(len(p)), np.empty(len(p), np.int32), np.empty((len(p), 3))
    step = max(1, _CHUNK // max(1, len(corners)))
    for i in range(0, len(p), step):
        x = p[i : i + step, None]
        candidates, ends = [], np.moveaxis(corners, 1, 0)
        for a, b in zip(ends, np.roll(ends, -1, axis=0), strict=True):
            length2 = ((b - a) ** 2).sum(axis=-1)
            t = np.einsum("nfi,fi->nf", x - a, b - a) / np.where(length2 > 0.0, length2, 1.0)
            candidates.append(a + np.clip(t, 0.0, 1.0)[..., None] * (b - a))
        a, b, c = ends
        normal = np.cross(b - a, c - a)
        square = (normal**2).sum(axis=-1)
        safe = np.where(square > 0.0, square, 1.0)
        foot = x - (np.einsum("nfi,fi->nf", x - a, normal) / safe)[..., None] * normal
        within = square > 0.0
        for s, e in ((a, b), (b, c), (c, a)):
            within = within & (np.einsum("nfi,fi->nf", np.cross(e - s, foot - s), normal) >= 0.0)
        candidates.append(np.where(within[..., None], foot, candidates[0]))
        every = np.stack(candidates)
        d2 = ((every - x) ** 2).sum(axis=-1)
        kind = d2.argmin(axis=0)
        d2 = d2.min(axis=0)
        rows = np.arange(len(d2))
        best = d2.argmin(axis=1)
        face[i : i + step] = best
        distance[i : i + step] = np.sqrt(d2[rows, best])
        closest[i : i + step] = every[kind[rows, best], rows, best]
    return distance, face, closest
