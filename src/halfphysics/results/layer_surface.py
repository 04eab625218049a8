"""The surface of a soft layer, and how it gives where something presses.

A layer has a visible surface and a hard frame below it. A vertex that gives goes against the
normals of its faces. What presses is known at samples: points with the depth that they are in the
layer. The surface w(x) >= 0 (depth, in metres) is that of foam under a skin: springs that also pull
at each other,

    w - l^2 laplace(w) = 0 beside the contact,  w >= the depth of the samples in it,

with l the length within which a dent fades (`FADES`). It is the smallest such surface: smooth
beside the contact, without a rim that bulges, and exactly zero farther away.

All is in the frame of the layer, in metres; V vertices, F faces, n samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.inset import plane_offsets
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.geometry.subdivision import subdivided

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Length within which a dent fades beside the contact to 1/e [m]: that of seat foam.
FADES = 0.025
#: A dent ends at this distance from the contact [m]: there a fiftieth would be left.
REACH = 4.0 * FADES
#: Longest edges of the surface at the contact, within `_CLOSE` of it, and as far as it reaches [m].
PITCH, COARSE, _CLOSE = 0.012, 0.025, 0.05
#: Most vertices of a surface; with more its edges are longer.
MOST_VERTICES = 20_000
# Share of the depth that is left at `REACH`, and is taken away everywhere.
_LEFT = float(np.exp(-4.0))
# Distances between samples are taken to be in this range [m].
_SPACING = (0.004, 0.04)
# Of as many neighbours as this, the farthest says how far apart samples are.
_AROUND = 3
# A vertex this near to a sample, in distances between them, is in the contact.
_COVERED = 0.75
# Depths in the contact are fitted to this many samples, by weights that fall off over this part of
# the distance between them.
_NEIGHBOURS, _WIDTH = 8, 0.7
# The longest way of a vertex for a metre of depth [m].
_LONGEST = 2.0
# Rounds of the search for the smallest surface; the first that spread the depth along edges.
_SPREAD, _SMOOTH = 14, 16
# A sample presses on vertices whose outward direction is within 72 degrees of its own.
_SAME_SIDE = 0.3


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """Samples in a layer, with their places on its unloaded surface.

    Attributes:
        place: Where they are on the surface (n, 3) [m].
        normal: Outward there (n, 3).
        depth: How deep they are below it (n,) [m].
        corner: Vertices of the face on which they are (n, 3).
        share: What each counts there, barycentric (n, 3).
    """

    place: Array
    normal: Array
    depth: Array
    corner: Ints
    share: Array

    def __len__(self) -> int:
        return len(self.depth)

    def __getitem__(self, rows: Any) -> Pressed:
        return Pressed(
            place=self.place[rows],
            normal=self.normal[rows],
            depth=self.depth[rows],
            corner=self.corner[rows],
            share=self.share[rows],
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class LayerSurface:
    """A layer's visible surface over its hard frame.

    Attributes:
        surface: Unloaded vertices (V, 3) [m].
        inner: Where each is when all of the layer has given (V, 3) [m]: on the frame or above it.
        faces: (F, 3), outward.
        thickness: Of the layer at every vertex (V,) [m].
    """

    surface: Array
    inner: Array
    faces: Ints
    thickness: Array

    @cached_property
    def _query(self) -> MeshQuery:
        return MeshQuery(self.surface, self.faces)

    @cached_property
    def outward(self) -> Array:
        """Direction from the frame to the surface at every vertex (V, 3): unit vectors."""
        way = self.surface - self.inner
        result: Array = way / np.maximum(np.linalg.norm(way, axis=1), 1e-12)[:, None]
        return result

    @cached_property
    def way(self) -> Array:
        """Where a vertex goes for each metre that it gives (V, 3)."""
        result: Array = (self.inner - self.surface) / np.maximum(self.thickness, 1e-12)[:, None]
        return result

    @cached_property
    def _neighbours(self) -> tuple[Ints, Ints, Array]:
        """Starts of the edges of each vertex (V,), their other ends and lengths (E,)."""
        ends = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]], self.faces[:, [2, 0]]])
        ends = np.unique(np.concatenate([ends, ends[:, ::-1]]), axis=0)
        starts = np.searchsorted(ends[:, 0], np.arange(len(self.surface)))
        length = np.linalg.norm(self.surface[ends[:, 0]] - self.surface[ends[:, 1]], axis=1)
        return starts, ends[:, 1], length

    def finer(self, places: Array | None, most: int = MOST_VERTICES) -> LayerSurface:
        """The same layer with edges short enough for dents at `places` (n, 3) [m].

        None: short everywhere. With more than `most` vertices they stay longer.
        """
        values = np.column_stack([self.surface, self.thickness])
        faces: Ints = np.asarray(self.faces, dtype=np.int64)
        if places is None:
            values, faces = subdivided(values, faces, COARSE, most)
        elif len(places):
            for length, reach in ((COARSE, REACH), (PITCH, _CLOSE)):
                near = _Near(places, reach)
                values, faces = subdivided(values, faces, length, most, near)
        surface, thickness = values[:, :3], values[:, 3]
        way = _inward(surface, faces)
        # Nowhere below the frame: where the thickness changes, the way may end a little inside it.
        frame = MeshQuery(self.inner, self.faces)
        inside = frame.depth(surface + thickness[:, None] * way)
        thickness = np.maximum(thickness - inside, 0.0)
        return LayerSurface(
            surface=surface,
            inner=surface + thickness[:, None] * way,
            faces=faces,
            thickness=thickness,
        )

    def part(self, vertices: Ints) -> LayerSurface:
        """The part of these vertices, and the faces between them."""
        index = np.full(len(self.surface), -1)
        index[vertices] = np.arange(len(vertices))
        faces = index[self.faces]
        return LayerSurface(
            surface=self.surface[vertices],
            inner=self.inner[vertices],
            faces=faces[(faces >= 0).all(axis=1)],
            thickness=self.thickness[vertices],
        )

    def facing(self, places: Array, normal: Array) -> NDArray[np.bool_]:
        """Whether normals (n, 3) are within 72 degrees of the surface's at places (n, 3) [m]."""
        _, face, _ = self._query.closest(places)
        corners = self.surface[self.faces[face]]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = np.einsum("ni,ni->n", across, normal)
        result: NDArray[np.bool_] = along > _SAME_SIDE * np.linalg.norm(across, axis=1)
        return result

    def pressed(self, places: Array, normal: Array, depth: Array) -> Pressed:
        """Samples by where they press.

        Args:
            places: Near the unloaded surface (n, 3) [m].
            normal: From the layer outward (n, 3).
            depth: Of the sample below that surface (n,) [m].
        """
        _, face, place = self._query.closest(places)
        corner = self.faces[face]
        share = _barycentric(self.surface[corner], place)
        most = (share * self.thickness[corner]).sum(axis=1)
        return Pressed(
            place=place,
            normal=normal,
            depth=np.clip(depth, 0.0, most),
            corner=corner,
            share=share,
        )

    def near(self, places: Array, reach: float) -> Ints:
        """The vertices within `reach` [m] of any of the places (n, 3)."""
        from scipy.spatial import cKDTree

        if not len(places):
            return np.zeros(0, dtype=np.int64)
        distance = cKDTree(places).query(self.surface, distance_upper_bound=reach)[0]
        return np.flatnonzero(np.isfinite(distance))

    def depths(self, pressed: Pressed) -> Array:
        """How far every vertex gives (V,) [m], at most the layer's thickness there."""
        if not len(pressed):
            return np.zeros(len(self.surface))
        least = self._in_contact(pressed)
        demand = self._demand(pressed)
        w = _raised(least, pressed, demand)
        starts, other, length = self._neighbours
        # Faces of a cut-off part may be gone: a vertex without an edge keeps its own.
        alone = np.diff(np.append(starts, len(other))) == 0
        fade = np.exp(-length / FADES)
        for _ in range(_SPREAD):
            w = np.where(alone, w, np.maximum(w, _reduced(np.maximum, fade * w[other], starts)))
        count = np.maximum(np.diff(np.append(starts, len(other))), 1)
        square = _reduced(np.add, length**2, starts) / count
        pull = 1.0 / (count * (1.0 + square / (4.0 * FADES**2)))
        for _ in range(_SMOOTH):
            mean = pull * _reduced(np.add, w[other], starts)
            w = _raised(np.maximum(np.where(alone, w, mean), least), pressed, demand)
        w = np.maximum((w - _LEFT * w.max()) / (1.0 - _LEFT), least)
        return np.minimum(_raised(w, pressed, demand), self.thickness)

    def at(self, depth: Array) -> Array:
        """The vertices (V, 3) [m] where each has given by `depth` (V,) [m]."""
        share = np.minimum(depth / np.maximum(self.thickness, 1e-12), 1.0)
        result: Array = self.surface + share[:, None] * (self.inner - self.surface)
        return result

    def _demand(self, pressed: Pressed) -> Array:
        """What a depth at each corner of a sample's face lowers the surface there (n, 3)."""
        along = np.einsum("nki,ni->nk", -self.way[pressed.corner], pressed.normal)
        result: Array = pressed.share * np.clip(along, 0.3, 1.0)
        return result

    def _in_contact(self, pressed: Pressed) -> Array:
        """Depth at vertices between samples (V,) [m]: a plane fitted to those nearby; else 0."""
        from scipy.spatial import cKDTree

        found = np.zeros(len(self.surface))
        tree = cKDTree(pressed.place)
        spacing = _spacing(tree, pressed.place)
        count = min(_NEIGHBOURS, len(pressed))
        far = 2.0 * float(spacing.max())
        r, row = tree.query(self.surface, k=count, distance_upper_bound=far)
        r, row = r.reshape(-1, count), row.reshape(-1, count)
        near = np.minimum(row[:, 0], len(pressed) - 1)
        mine = np.flatnonzero(r[:, 0] < _COVERED * spacing[near])
        r, row = r[mine], np.minimum(row[mine], len(pressed) - 1)
        spacing = spacing[row[:, :1]]
        same = np.einsum("vi,vki->vk", self.outward[mine], pressed.normal[row]) > _SAME_SIDE
        weight = np.where(np.isfinite(r) & same, np.exp(-((r / (_WIDTH * spacing)) ** 2)), 0.0)
        depth = pressed.depth[row]
        way = (pressed.place[row] - self.surface[mine][:, None]) / spacing[:, :, None]
        terms = np.concatenate([np.ones((*r.shape, 1)), way], axis=2)
        normal = np.einsum("vk,vki,vkj->vij", weight, terms, terms)
        normal += np.diag([1e-9, 0.05, 0.05, 0.05])  # few samples say nothing of a slope
        right = np.einsum("vk,vki,vk->vi", weight, terms, depth)
        fitted = np.linalg.solve(normal, right[..., None])[:, 0, 0]
        some = weight.sum(axis=1) > 1e-6
        most = np.where(weight > 0.0, depth, 0.0).max(axis=1, initial=0.0)
        found[mine] = np.where(some, np.clip(fitted, 0.0, most), 0.0)
        return found


class _Near:
    """Whether balls are within `reach` [m] of any of the places (n, 3)."""

    def __init__(self, places: Array, reach: float) -> None:
        from scipy.spatial import cKDTree

        self._tree, self._reach = cKDTree(places), reach

    def __call__(self, centre: Array, radius: Array) -> NDArray[np.bool_]:
        distance = self._tree.query(centre)[0]
        result: NDArray[np.bool_] = distance < radius + self._reach
        return result


def _reduced(operation: Any, values: Array, starts: Sequence[int] | Ints) -> Array:
    """Sum or largest of the values of each vertex's edges; of one without edges, anything."""
    padded = np.append(values, 0.0)  # the last vertex may have no edge
    result: Array = operation.reduceat(padded, starts)
    return result


def _inward(points: Array, faces: Ints) -> Array:
    """Where vertices go for each metre of depth (V, 3): at an edge aslant, and not too far."""
    way = plane_offsets(points, faces.astype(np.int32))
    size = np.linalg.norm(way, axis=1, keepdims=True)
    result: Array = way * np.minimum(1.0, _LONGEST / np.maximum(size, _LONGEST))
    return result


def _spacing(tree: Any, places: Array) -> Array:
    """Distance of each sample from those around it (n,) [m]: on a grid, its pitch."""
    around = min(_AROUND, len(places) - 1)
    if around < 1:
        return np.full(len(places), _SPACING[0])
    result: Array = np.clip(tree.query(places, k=around + 1)[0][:, around], *_SPACING)
    return result


def _raised(w: Array, pressed: Pressed, demand: Array) -> Array:
    """Depths `w` (V,) raised so that the surface lies nowhere above a sample."""
    there = (demand * w[pressed.corner]).sum(axis=1)
    lack = (pressed.depth - there) / np.maximum(demand.sum(axis=1), 0.1)
    short = lack > 0.0
    out = w.copy()
    wanted = w[pressed.corner[short]] + lack[short, None]
    np.maximum.at(out, pressed.corner[short].ravel(), wanted.ravel())
    return out


def _barycentric(corners: Array, points: Array) -> Array:
    """Barycentric coordinates (n, 3) of points (n, 3) on triangles (n, 3, 3)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = points - corners[:, 0]
    aa, ab, bb = ((x * y).sum(axis=1) for x, y in ((a, a), (a, b), (b, b)))
    pa, pb = (p * a).sum(axis=1), (p * b).sum(axis=1)
    area = np.maximum(aa * bb - ab * ab, 1e-300)
    v, w = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    share = np.clip(np.stack([1.0 - v - w, v, w], axis=1), 0.0, 1.0)
    result: Array = share / share.sum(axis=1, keepdims=True)
    return result
