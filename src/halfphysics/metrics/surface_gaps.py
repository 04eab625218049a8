"""Signed distance of points from a shape, and the gap between skin and what can carry it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.metrics.argument_checks import Array
from halfphysics.metrics.scene_solids import Solid, solids_of, tracks_of
from halfphysics.metrics.skins import batches, frames_in, frames_of, skin
from halfphysics.metrics.solid_boxes import distance_bound

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

#: A surface can carry where the way from it to the skin rises by at least this (30 degrees): a wall
#: beside a person, or a ceiling, carries nobody.
RISE = 0.5
#: Skin that faces up by more than this is not carried (it would have to lie at -0.5, and bends by
#: less than 50 degrees more than its part): it is left out for speed.
FACING = 0.3
#: Shortest way of which the direction is known [m].
_LEAST = 1e-9
#: Every so many vertices are measured first, so that most of the others need not be.
_SPARSE = 16

Whole = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Gaps:
    """Gaps of groups of skin vertices; T frames, G groups.

    Attributes:
        gap: Smallest signed distance of the group from a surface that can carry it (T, G) [m]:
            negative inside, inf where no such surface is below it.
        vertex: The vertex of that gap (T, G); -1 where it is inf.
        item: Index into `names` of that surface (T, G); -1 likewise.
        names: Names of statics, objects and links.
    """

    gap: Array
    vertex: Whole
    item: Whole
    names: tuple[str, ...]

    @property
    def whole(self) -> Array:
        """Smallest gap of all groups (T,) [m]."""
        smallest: Array = self.gap.min(axis=1)
        return smallest


def signed_distance(shape: Shape, points: Array) -> tuple[Array, Array]:
    """Signed distances (n,) [m] of points (n, 3) from a shape, negative inside, and unit
    directions (n, 3) of the shortest way out of it; all in the shape's frame.

    Raises:
        TypeError: An unknown kind of shape.
    """
    if isinstance(shape, Plane):
        normal = np.asarray(shape.normal)
        return points @ normal - shape.offset, np.broadcast_to(normal, points.shape)
    if isinstance(shape, Mesh):
        return _from_mesh(shape, points)
    if isinstance(shape, Box):
        return _from_box(points, 0.5 * np.asarray(shape.size))
    if isinstance(shape, Sphere | Capsule):
        out = points.copy()
        half = 0.0 if isinstance(shape, Sphere) else 0.5 * shape.length
        out[:, 2] -= np.clip(out[:, 2], -half, half)
        length = np.linalg.norm(out, axis=1)
        return length - shape.radius, _unit(out, length)
    if isinstance(shape, Cylinder):
        radius = np.hypot(points[:, 0], points[:, 1])
        flat = np.stack([radius, points[:, 2]], axis=1)
        distance, way = _from_box(flat, np.array([shape.radius, 0.5 * shape.length]))
        beside = points[:, :2] * (way[:, 0] / np.maximum(radius, _LEAST))[:, None]
        return distance, np.concatenate([beside, way[:, 1:]], axis=1)
    raise TypeError(f"shape: found {type(shape).__name__}, expected one of halfphysics")


def carrying_gaps(
    motion: Any,
    body: Any,
    scene: Scene,
    group: NDArray[np.integer],
    *,
    objects: Mapping[str, Any] | None = None,
    reach: float = 1.0,
    visible: bool = False,
) -> Gaps:
    """Smallest gaps of groups of skin vertices above the surfaces that can carry them.

    A surface can carry a vertex if the shortest way from it to the vertex rises by at least 30
    degrees. Items that people ignore carry nobody.

    Args:
        motion: T frames.
        body: Its skin is measured.
        scene: Statics, objects and links.
        group: Group of every vertex (V,), 0 to G - 1, or -1: not measured.
        objects: Name -> track of T poses, as in ``result.objects``; those not named are left out.
        reach: Largest gap that is measured [m]; beyond it is inf.
        visible: Whether gaps to what is soft are those to its surface that nothing presses; else
            to its hard frame.

    Raises:
        InputError: A track of another length, or of no object of the scene.
    """
    frames, count = frames_of(motion), int(group.max()) + 1
    tracks = tracks_of(scene, objects or {}, frames)
    solids = solids_of(scene, tracks, visible=visible)
    found = _Nearest(np.full((frames, count), float(reach)))
    rest = _rest_normals(body)
    # Bounds are taken part by part: what stands needs no look at the head.
    part_of = np.zeros_like(group) if rest is None else rest[0]
    cells, cell = np.unique(np.stack([group, part_of]), axis=1, return_inverse=True)
    cell = np.where(group >= 0, cell.reshape(-1), -1)
    for part in batches(frames, "distances to surfaces"):
        vertices = skin(motion, body, part)
        wanted = np.broadcast_to(group >= 0, vertices.shape[:2])
        if rest is not None:
            wanted = wanted & _may_be_carried(body, motion, part, rest)
        bounds = _bounds(vertices, cell, cells.shape[1])
        for sparse in (True, False):
            some = wanted.copy()
            if sparse:
                some[:, np.arange(some.shape[1]) % _SPARSE != 0] = False
            for k, its in enumerate(solids.values()):
                for solid in its:
                    found.look(k, solid, part, vertices, some, group, (cell, cells[0], *bounds))
    gap = np.where(found.vertex < 0, np.inf, found.gap)
    return Gaps(gap=gap, vertex=found.vertex, item=found.item, names=tuple(solids))


class _Nearest:
    """The smallest gaps so far (T, G), and whose they are."""

    def __init__(self, gap: Array) -> None:
        self.gap = gap
        self.vertex = np.full(gap.shape, -1)
        self.item = np.full(gap.shape, -1)

    def look(
        self,
        item: int,
        solid: Solid,
        part: slice,
        vertices: Array,
        wanted: NDArray[np.bool_],
        group: NDArray[np.integer],
        bounds: tuple[NDArray[np.integer], NDArray[np.integer], Array, Array],
    ) -> None:
        """Measure `wanted` (t, V) of the vertices (t, V, 3) of the frames `part` from a solid.

        `bounds`: cell of every vertex (V,), group of every cell (C,), and the middle and half size
        (t, C, 3) of boxes around the cells. Those farther than what their group has are passed
        over.
        """
        shape, *pose = solid
        turns = rot.to_matrix(pose[1] if len(pose[1]) == 1 else pose[1][part])
        places = pose[0] if len(pose[0]) == 1 else pose[0][part]
        cell, group_of, middle, half = bounds
        near = distance_bound(shape, places, turns, middle, half) < self.gap[part][:, group_of]
        if not near.any():
            return
        t, v = np.nonzero(wanted & near[:, cell])
        its = np.zeros_like(t) if len(places) == 1 else t
        local = np.einsum("ni,nij->nj", vertices[t, v] - places[its], turns[its])
        frame = t + part.start
        if isinstance(shape, Mesh):
            low, high = shape.query.bounds
            beyond = np.linalg.norm(np.maximum(np.maximum(low - local, local - high), 0.0), axis=1)
            near = (beyond == 0.0) | (beyond < self.gap[frame, group[v]])
            t, v, its, local, frame = t[near], v[near], its[near], local[near], frame[near]
        distance, way = signed_distance(shape, local)
        carries = np.einsum("nj,nj->n", way, turns[its][:, 2]) >= RISE
        better = np.flatnonzero(carries & (distance < self.gap[frame, group[v]]))
        # The smallest last, so that it stays.
        better = better[np.argsort(-distance[better], kind="stable")]
        at = frame[better], group[v[better]]
        self.gap[at], self.vertex[at], self.item[at] = distance[better], v[better], item


def _bounds(vertices: Array, cell: NDArray[np.integer], count: int) -> tuple[Array, Array]:
    """Middle and half size (t, C, 3) of boxes around cells of the vertices (t, V, 3)."""
    order = np.argsort(cell, kind="stable")
    found, first = np.unique(cell[order], return_index=True)
    middle = np.full((len(vertices), count, 3), 1e9)  # no vertex: far from all
    half = np.zeros_like(middle)
    for number, its in zip(found, np.split(order, first[1:]), strict=True):
        if number >= 0:
            corners = vertices[:, its]
            low, high = corners.min(axis=1), corners.max(axis=1)
            middle[:, number], half[:, number] = 0.5 * (low + high), 0.5 * (high - low)
    return middle, half


def _rest_normals(body: Any) -> tuple[NDArray[np.intp], Array] | None:
    """Of every vertex: its part (V,) and its normal at rest (V, 3); None: the body has no parts."""
    faces = np.asarray(body.faces)
    if not len(faces) or not hasattr(body, "weights"):
        return None
    a, b, c = (body.rest_vertices[faces[:, k]] for k in range(3))
    normal, face = np.zeros(body.rest_vertices.shape), np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normal, faces[:, k], face)
    return body.weights.argmax(axis=1), _unit(normal, np.linalg.norm(normal, axis=1))


def _may_be_carried(
    body: Any, motion: Any, part: slice, rest: tuple[NDArray[np.intp], Array]
) -> NDArray[np.bool_]:
    """Vertices (t, V) whose normal, turned with their part, does not point up by over `FACING`."""
    posed = body.joint_frames(frames_in(motion, part))[1]
    turns = rot.to_matrix(posed.reshape(-1, 55, 4))
    of, normal = rest
    upward = np.einsum("tvi,vi->tv", turns[:, :, 2][:, of], normal)
    result: NDArray[np.bool_] = upward < FACING
    return result


def _from_box(points: Array, half: Array) -> tuple[Array, Array]:
    """Signed distances and ways of points (n, d) from a box about the origin, half sizes (d,)."""
    beyond = np.abs(points) - half
    out = np.maximum(beyond, 0.0)
    length = np.linalg.norm(out, axis=1)
    side = np.where(points < 0.0, -1.0, 1.0)
    inside = length == 0.0
    nearest = np.eye(len(half))[beyond.argmax(axis=1)]
    way = np.where(inside[:, None], nearest, _unit(out, length))
    return np.where(inside, beyond.max(axis=1), length), way * side


def _from_mesh(mesh: Mesh, points: Array) -> tuple[Array, Array]:
    if not len(points):
        return np.zeros(0), np.zeros((0, 3))
    distance, face, closest = mesh.query.closest(points)
    out = points - closest
    corners = mesh.vertices[mesh.outward.faces[face]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    way = np.where(
        (distance > _LEAST)[:, None],
        _unit(out, distance),
        _unit(normal, np.linalg.norm(normal, axis=1)),
    )
    low, high = mesh.query.bounds
    within = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    inside = within[mesh.query.inside(points[within])] if len(within) else within
    sign = np.ones(len(points))
    sign[inside] = -1.0
    return sign * distance, np.where((distance > _LEAST)[:, None], sign[:, None] * way, way)


def _unit(vectors: Array, length: Array) -> Array:
    """Vectors of length 1; (0, 0, 1) where they have none."""
    unit = vectors / np.maximum(length, _LEAST)[:, None]
    unit[length <= _LEAST] = np.eye(vectors.shape[1])[-1]
    return unit
