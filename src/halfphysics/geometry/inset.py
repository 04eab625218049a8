"""Inset: a surface moved inward, the hard frame under a soft layer of a mesh.

Every vertex moves so that the planes of its faces move by its thickness t: d is the least squares
solution of n_i . d = -t over the unit normals n_i of the faces around it, weighted by area; exact
at the edges and corners of solids with flat sides. Where the solid is thin, t is less: at most
`SHARE` of the way to the opposite surface, found along d by the distance from the surface, which
grows up to the middle of a wall and falls beyond it. Where d ends nearer to another side than t
(a rounded edge that is narrower than the layer), the vertex is pushed away from that side.

That takes seconds for tens of thousands of vertices; what came of it is kept on the disk for the
next time (`inset_cache`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.geometry import inset_cache
from halfphysics.geometry.mesh_queries import MeshQuery, is_closed

Array = NDArray[np.float64]
Indices = NDArray[np.int32]

#: Largest share of the way to the opposite surface: a tenth of every wall stays hard.
SHARE = 0.45
#: Directions count where their share of the faces' normals is over this: the second one of an edge
#: whose faces are bent by 15 degrees. Flatter edges move along their mean normal.
FLAT = 0.017
#: Longest way of a vertex, in multiples of t: the tip of a wedge of 19 degrees.
LONGEST = 6.0
#: A surface is opposite where the distance falls by this share of the way: it is inclined by less
#: than 45 degrees.
OPPOSITE = 0.7
#: Steps along the way at which the middle of a wall is looked for, and halvings of the best one:
#: to a thousandth.
STEPS, HALVINGS = 12, 12
#: Pushes away from sides that are too near, and the share of t that may be left.
PUSHES, NEAR = 16, 2e-3


@dataclass(frozen=True)
class Inset:
    """What came of it: `vertices` (V, 3) [m] inside, and `thickness` (V,) [m] over each."""

    vertices: Array
    thickness: Array


def inset(vertices: Array, faces: Indices, thickness: ArrayLike) -> Inset:
    """Move the vertices of a surface inward.

    Args:
        vertices, faces: (V, 3) [m], (F, 3) counter-clockwise seen from outside; every vertex used.
        thickness: How far the planes of faces should move: a number or (V,) [m].

    Returns:
        New vertices in the same order. The thickness over each is its distance from the surface,
        at most what was asked.
    """
    t = np.array(np.broadcast_to(np.asarray(thickness, dtype=np.float64), (len(vertices),)))
    if len(vertices) < inset_cache.FEWEST:
        return _made(vertices, faces, t)
    key = inset_cache.key_of(vertices, faces, t)
    kept = inset_cache.read(key, len(vertices))
    if kept is not None:
        return Inset(*kept)
    made = _made(vertices, faces, t)
    inset_cache.write(key, made.vertices, made.thickness)
    return made


def _made(vertices: Array, faces: Indices, t: Array) -> Inset:
    surface = _Surface(vertices, faces)
    t = np.minimum(t, SHARE * surface.walls(t))
    every = np.arange(len(vertices))
    inner, good = surface.inside_by(t, every)
    bad = every[~good]
    if len(bad):
        t[bad] = 2.0 * SHARE * _most(surface, t[bad], bad)
        inner[bad] = surface.inside_by(t[bad], bad)[0]
    return Inset(inner, np.minimum(t, surface.distance(inner)))


def _most(surface: _Surface, t: Array, some: NDArray[np.int64]) -> Array:
    """The largest depths (n,), less than t (n,), for which the vertices `some` (n,) have room."""
    low, high = np.zeros(len(t)), t.copy()
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        good = surface.inside_by(middle, some)[1]
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low


class _Surface:
    """A surface and the ways of its vertices inward."""

    def __init__(self, vertices: Array, faces: Indices) -> None:
        self._vertices = vertices
        self._query = MeshQuery(vertices, faces)
        self._closed = is_closed(faces, len(vertices))
        self._way = plane_offsets(vertices, faces)

    def distance(self, points: Array) -> Array:
        """Of points (n, 3) from the surface (n,) [m]."""
        return self._query.closest(points)[0]

    def walls(self, most: Array) -> Array:
        """Way through the wall at each vertex (V,); inf where half is not before most / (2 SHARE).

        Twice the way to where the distance from the surface is largest.
        """
        last = most / (2.0 * SHARE) * (1.0 + 1.0 / STEPS)
        result = np.full(len(most), np.inf)
        # Where the way's end is as far from the surface as from its start, nothing is near it.
        open_ = np.flatnonzero(self._far(last) < (1.0 - NEAR) * last)
        share = np.arange(1, STEPS + 1) / STEPS
        found = np.stack([self._far(s * last[open_], open_) for s in share])
        falls = found[1:] < found[:-1] - OPPOSITE * last[open_] / STEPS
        chosen = np.flatnonzero(falls.any(axis=0))
        if not len(chosen):
            return result
        some = open_[chosen]
        first, end = falls.argmax(axis=0)[chosen], last[some]
        low = np.where(first == 0, 0.0, share[np.maximum(first - 1, 0)]) * end
        high = share[first + 1] * end
        for _ in range(HALVINGS):
            one, two = low + (high - low) / 3.0, high - (high - low) / 3.0
            rises = self._far(one, some) < self._far(two, some)
            low, high = np.where(rises, one, low), np.where(rises, high, two)
        result[some] = low + high
        return result

    def _far(self, way: Array, some: NDArray[np.int64] | slice = slice(None)) -> Array:
        """Distances from the surface of the vertices `some` that went so far on their ways."""
        return self.distance(self._vertices[some] + way[:, None] * self._way[some])

    def inside_by(self, t: Array, some: NDArray[np.int64]) -> tuple[Array, NDArray[np.bool_]]:
        """Vertices `some` (n,) moved inward by t (n,) and away from what is nearer than that.

        Returns:
            Where they are (n, 3), and which of them (n,) have their depth, inside, not far off.
        """
        start = self._vertices[some]
        inner = start + t[:, None] * self._way[some]
        left = np.arange(len(some))
        for _ in range(PUSHES):
            far, _, place = self._query.closest(inner[left])
            short = far < (1.0 - NEAR) * t[left]
            if not short.any():
                break
            left, far, place = left[short], far[short], place[short]
            away = (inner[left] - place) / np.maximum(far, 1e-12)[:, None]
            # What came out on another side goes back in through where that is nearest.
            side = np.where(self._inside(inner[left]), 1.0, -1.0)
            inner[left] = place + (side * t[left])[:, None] * away
        good = self.distance(inner) >= (1.0 - 2.0 * NEAR) * t
        good &= np.linalg.norm(inner - start, axis=1) <= LONGEST * t + 1e-12
        return inner, good & self._inside(inner)

    def _inside(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) are in the solid; of a surface that is not closed, all are."""
        return self._query.inside(points) if self._closed else np.ones(len(points), dtype=bool)


def plane_offsets(vertices: Array, faces: Indices) -> Array:
    """Where each vertex goes (V, 3) when the planes of its faces move inward by 1."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1)
    normal = across / np.maximum(area, 1e-300)[:, None]
    outer = area[:, None, None] * normal[:, :, None] * normal[:, None, :]
    matrix, mean, total = (np.zeros((len(vertices), *s)) for s in ((3, 3), (3,), ()))
    for corner in faces.T:
        np.add.at(matrix, corner, outer)
        np.add.at(mean, corner, across)
        np.add.at(total, corner, area)
    total = np.maximum(total, 1e-300)
    value, axes = np.linalg.eigh(matrix / total[:, None, None])
    along = np.einsum("vij,vi->vj", axes, mean / total[:, None])
    share = np.where(value > FLAT, along / np.maximum(value, FLAT), 0.0)
    offsets = -np.einsum("vij,vj->vi", axes, share)
    length = np.linalg.norm(offsets, axis=1, keepdims=True)
    result: Array = offsets * np.minimum(1.0, LONGEST / np.maximum(length, LONGEST))
    return result
