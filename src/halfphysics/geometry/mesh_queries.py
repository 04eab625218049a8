"""Queries of points against a triangle mesh: inside or not, distance to the surface.

*Inside* means a generalised winding number over 0.5 (Jacobson et al. 2013): the solid angle
that the triangles span at the point, over 4 pi, outward triangles (counter-clockwise seen from
outside) counted positive. It is defined for any soup: a closed surface gives 1 inside and 0
outside, a surface with a hole goes smoothly from one to the other across the hole. A closed
surface turned inside out gives -1 in its interior, so nothing is inside it; if windings are mixed
at random the contributions cancel and little or nothing is inside.

`MeshQuery` is native. `tests/support/references/mesh_queries.py` has the same in plain numpy; the
tests hold both equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of
from halfphysics.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.int32]


def _points(points: ArrayLike) -> Array:
    array = np.ascontiguousarray(array_of(points), dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"points: expected shape (n, 3), found {array.shape}")
    if not np.isfinite(array).all():
        raise InputError("points: found NaN or infinity, expected finite coordinates [m]")
    return array


def merge_vertices(vertices: Array, faces: ArrayLike) -> tuple[Array, Indices]:
    """The same triangles with vertices at exactly one place made one, unused ones dropped.

    Triangles that name one vertex twice have no area and are dropped too.
    Vertices (V, 3), faces (F, 3) -> vertices (V', 3), faces (F', 3) int32.
    """
    faces = np.asarray(faces)
    used, inverse = np.unique(faces, return_inverse=True)
    # + 0.0: -0.0 and 0.0 are one place.
    merged, place = np.unique(vertices[used] + 0.0, axis=0, return_inverse=True)
    new = place.reshape(-1)[inverse.reshape(-1)].reshape(-1, 3)
    distinct = (new[:, 0] != new[:, 1]) & (new[:, 1] != new[:, 2]) & (new[:, 2] != new[:, 0])
    new = new[distinct]
    kept, renumbered = np.unique(new, return_inverse=True)
    return merged[kept], renumbered.reshape(-1, 3).astype(np.int32)


def components(n: int, edges: NDArray[np.integer]) -> NDArray[np.int32]:
    """Label (n,) of the connected component of every vertex; edges (k, 2)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(len(edges), dtype=np.int8)
    graph = coo_array((ones, (edges[:, 0], edges[:, 1])), shape=(n, n))
    result: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return result


def boundary_edges(faces: Indices, n_vertices: int) -> NDArray[np.int64]:
    """Directed edges (k, 2) that no triangle runs the other way, once per unmatched run.

    Empty for a closed, consistently wound surface. Expects merged vertices.
    """
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    low, high = edges.min(axis=1), edges.max(axis=1)
    key, which = np.unique(low * n_vertices + high, return_inverse=True)
    forward = edges[:, 0] == low
    balance = np.bincount(which, weights=np.where(forward, 1.0, -1.0)).astype(np.int64)
    pairs = np.stack([key // n_vertices, key % n_vertices], axis=1)
    pairs = np.where(balance[:, None] < 0, pairs[:, ::-1], pairs)
    return np.repeat(pairs, np.abs(balance), axis=0)


def is_closed(faces: Indices, n_vertices: int) -> bool:
    """Whether every edge is used as often one way as the other; expects merged vertices."""
    return len(boundary_edges(faces, n_vertices)) == 0


def piece_count(faces: Indices, n_vertices: int) -> int:
    """Number of pieces that share no vertex; expects merged vertices, all of them used."""
    return int(components(n_vertices, np.concatenate([faces[:, :2], faces[:, 1:]])).max()) + 1


@dataclass(frozen=True)
class _Split:
    """A soup as closed triangles plus loose ones: w = w(closed) + w(loose)."""

    closed_vertices: Array
    closed: Indices
    loose_vertices: Array
    loose: Indices


def _split(vertices: Array, faces: Indices) -> _Split:
    """Close each connected piece by fans over its holes; the fans, turned round, are the rest.

    Closed triangles have whole winding numbers, found by one ray; the loose rest is few
    triangles where a mesh has few holes. Pieces with more boundary than faces are all loose.
    """
    vertices, faces = merge_vertices(vertices, faces)
    n = len(vertices)
    if not len(faces):
        return _Split(vertices, faces, vertices, faces)
    piece = components(n, np.concatenate([faces[:, :2], faces[:, 1:]]))
    rim = boundary_edges(faces, n)
    size = int(piece.max()) + 1
    in_faces = np.bincount(piece[faces[:, 0]], minlength=size)
    in_rim = np.bincount(piece[rim[:, 0]], minlength=size)
    ragged = in_rim >= in_faces
    keep = ~ragged[piece[faces[:, 0]]]
    rim = rim[~ragged[piece[rim[:, 0]]]]
    if not len(rim):
        return _Split(vertices, faces[keep], vertices, faces[~keep])
    # One apex per connected rim: the mean of its edges' ends.
    rims = components(n, rim)
    used, rank = np.unique(rims[rim[:, 0]], return_inverse=True)
    apex = np.zeros((len(used), 3))
    np.add.at(apex, rank, 0.5 * (vertices[rim[:, 0]] + vertices[rim[:, 1]]))
    apex /= np.bincount(rank)[:, None]
    fans = np.stack([rim[:, 1], rim[:, 0], n + rank], axis=1).astype(np.int32)
    every = np.concatenate([vertices, apex])
    loose = np.concatenate([faces[~keep], fans[:, ::-1]])
    return _Split(every, np.concatenate([faces[keep], fans]), every, loose)


class MeshQuery:
    """Winding numbers and distances of points to one triangle mesh, fast.

    `vertices` (V, 3) [m], `faces` (F, 3). The native tree answers; results do not depend on
    `threads`. `closed`: the faces are known to be (`is_closed`), which saves looking for holes.
    Raises `InputError` for impossible arrays.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, *, closed: bool = False) -> None:
        import halfphysics._native as native

        v = _points(vertices)
        f = np.ascontiguousarray(faces, dtype=np.int32)
        if f.ndim != 2 or f.shape[1] != 3 or not len(f):
            raise InputError(f"faces: expected shape (F, 3) with F > 0, found {f.shape}")
        if f.min() < 0 or f.max() >= len(v):
            raise InputError(
                f"faces: expected indices 0 to {len(v) - 1}, found {f.min()} to {f.max()}"
            )
        self._made_of = (v, f, closed)
        corners = v[np.unique(f)]
        #: Corners (2, 3) of the box around all triangles.
        self.bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
        #: The native tree over all triangles.
        self.tree = native.TriangleTree(v, f)
        self._closed: native.TriangleTree | None = self.tree
        self._loose: native.TriangleTree | None = None
        if closed:
            return
        split = _split(v, f)
        self._closed = (
            native.TriangleTree(split.closed_vertices, split.closed) if len(split.closed) else None
        )
        self._loose = (
            native.TriangleTree(split.loose_vertices, split.loose, winding=True)
            if len(split.loose)
            else None
        )

    def __reduce__(self) -> Any:
        # The trees are the core's: they are built again.
        return _query, self._made_of

    def winding(self, points: ArrayLike, *, tolerance: float = 1e-9, threads: int = 1) -> Array:
        """Generalised winding numbers (n,) of points (n, 3), off by at most `tolerance`."""
        p = _points(points)
        total = np.zeros(len(p))
        if self._closed is not None:
            total += self._closed.crossings(p, threads)
        if self._loose is not None:
            total += self._loose.winding(p, tolerance, threads)
        return total

    def enclosed(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points (n, 3) are inside, whichever way the faces look (n,)."""
        result: NDArray[np.bool_] = np.abs(self.winding(points)) > 0.5
        return result

    def inside(self, points: ArrayLike, *, threads: int = 1) -> NDArray[np.bool_]:
        """Whether the winding number of points (n, 3) is over 0.5, (n,)."""
        p = _points(points)
        whole = np.zeros(len(p))
        if self._closed is not None:
            whole += self._closed.crossings(p, threads)
        if self._loose is None:
            return whole > 0.5
        result: NDArray[np.bool_] = self._loose.exceeds(p, 0.5 - whole, threads).astype(bool)
        return result

    def closest(self, points: ArrayLike, *, threads: int = 1) -> tuple[Array, Indices, Array]:
        """Distance (n,) [m], nearest face (n,) and its closest point (n, 3) for points (n, 3).

        Of several faces equally near, the one listed first.
        """
        result: tuple[Array, Indices, Array] = self.tree.distance(_points(points), threads)
        return result

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """How far points (n, 3) are inside [m], (n,): 0 outside, else the distance to the surface.

        Points beyond the mesh's bounding box count as outside.
        """
        p = _points(points)
        depth = np.zeros(len(p))
        near = np.flatnonzero(((p >= self.bounds[0]) & (p <= self.bounds[1])).all(axis=1))
        within = near[self.inside(p[near], threads=threads)]
        depth[within] = self.closest(p[within], threads=threads)[0]
        return depth


def _query(vertices: Array, faces: Indices, closed: bool) -> MeshQuery:
    for array in (vertices, faces):
        array.setflags(write=False)
    return MeshQuery(vertices, faces, closed=closed)
