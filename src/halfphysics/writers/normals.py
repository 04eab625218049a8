"""Normals of triangle meshes, and the split that keeps sharp edges sharp."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.integer]

# Normal of a vertex without faces, or with degenerate faces only.
_NO_NORMAL = np.array([0.0, 0.0, 1.0])


def vertex_normals(vertices: Array, faces: Faces) -> Array:
    """Unit normals (V, 3) of a smooth surface: face normals, weighted by their angle."""
    return _summed(faces.ravel(), _corner_normals(vertices, faces), len(vertices))


def creased(vertices: Array, faces: Faces, degrees: float) -> tuple[Array, Faces, Array]:
    """The same surface with separate vertices on both sides of its sharp edges.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        degrees: Edges that bend by less stay smooth.

    Returns:
        Vertices (W, 3), faces (F, 3) and unit normals (W, 3); unused vertices are left out.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corner_normals = _corner_normals(vertices, faces)
    size = np.linalg.norm(corner_normals, axis=1, keepdims=True)
    unit = (corner_normals / np.where(size > 0.0, size, 1.0)).reshape(-1, 3, 3)
    # Half edges: corner k to corner k + 1 of a face, sorted so that those of one edge are adjacent.
    corner = np.arange(3 * len(faces)).reshape(-1, 3)
    start, stop = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    flat = faces.ravel()
    swapped = flat[start] > flat[stop]
    low, high = np.where(swapped, stop, start), np.where(swapped, start, stop)
    order = np.lexsort((flat[high], flat[low]))
    low, high = low[order], high[order]
    same = (flat[low[1:]] == flat[low[:-1]]) & (flat[high[1:]] == flat[high[:-1]])
    of_face = unit[:, 0]
    bend = np.einsum("ni,ni->n", of_face[low[1:] // 3], of_face[low[:-1] // 3])
    smooth = same & (bend > np.cos(np.radians(degrees)))
    a = np.concatenate([low[1:][smooth], high[1:][smooth]])
    b = np.concatenate([low[:-1][smooth], high[:-1][smooth]])
    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(len(flat), len(flat)))
    count, split = connected_components(graph, directed=False)
    out = np.empty((count, 3))
    out[split] = vertices[flat]
    return out, split.reshape(-1, 3), _summed(split, corner_normals, count)


def _corner_normals(vertices: Array, faces: Faces) -> Array:
    """The faces' normals times the angle at every corner (3 F, 3); 0 for degenerate faces."""
    corners = vertices[faces]
    forward = np.roll(corners, -1, axis=1) - corners
    backward = np.roll(corners, 1, axis=1) - corners
    normal = np.cross(forward[:, 0], backward[:, 0])
    size = np.linalg.norm(normal, axis=1)
    across = np.linalg.norm(np.cross(forward, backward), axis=2)
    angle = np.arctan2(across, np.einsum("fki,fki->fk", forward, backward))
    unit = normal / np.where(size > 0.0, size, 1.0)[:, None]
    result: Array = (angle[..., None] * unit[:, None]).reshape(-1, 3)
    return result


def _summed(index: Faces, values: Array, count: int) -> Array:
    """Normalised sums (count, 3) of the `values` (n, 3) with the same index."""
    total = np.stack([np.bincount(index, column, count) for column in values.T], axis=1)
    size = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(size > 1e-12, total / np.where(size > 0.0, size, 1.0), _NO_NORMAL)
