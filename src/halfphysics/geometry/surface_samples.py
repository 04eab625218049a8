"""Samples of a surface: points with outward normals and areas, which stand for all of it.

Areas sum to the surface's own area (of a sphere, capsule and cylinder the true one), and on flat
and on round faces the samples have their second moments too: where pressure is linear over a face,
sums over samples are its integrals.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.shape_base import Array, Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere

#: Samples lie this far apart at most, and at least [m].
WIDEST, FINEST = 0.02, 0.002
#: How many of them go along the least extent of a round shape, and of another: 16 let a ball sink
#: as it should to 1 %; flat faces are exact with any number.
ROUND, FLAT = 16, 8
#: Most samples of one shape; then they are farther apart.
MOST = 4_000


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """`points` (n, 3) [m], unit outward `normals` (n, 3), `areas` (n,) [m^2]."""

    points: Array
    normals: Array
    areas: Array

    def __len__(self) -> int:
        return len(self.areas)

    def __getitem__(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> SurfaceSamples:
        return SurfaceSamples(self.points[rows], self.normals[rows], self.areas[rows])

    def moved(self, rotation: Array, position: Array) -> SurfaceSamples:
        """The same samples under a rotation (3, 3) and a shift (3,)."""
        return SurfaceSamples(
            self.points @ rotation.T + position, self.normals @ rotation.T, self.areas
        )


def joined(samples: list[SurfaceSamples]) -> SurfaceSamples:
    """Several as one."""
    empty = SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    each = [empty, *samples]
    return SurfaceSamples(
        np.concatenate([s.points for s in each]),
        np.concatenate([s.normals for s in each]),
        np.concatenate([s.areas for s in each]),
    )


def pitch_for(shape: Shape) -> float:
    """How far apart the samples of a solid should be [m]."""
    if isinstance(shape, Sphere):
        least, area = 2.0 * shape.radius, 4.0 * np.pi * shape.radius**2
    else:
        vertices, faces = shape.triangles()
        a, b, c = np.moveaxis(vertices[faces], 1, 0)
        least = float(np.ptp(vertices, axis=0).min())
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    across = ROUND if isinstance(shape, Sphere | Capsule | Cylinder) else FLAT
    wanted = min(max(least / across, FINEST), WIDEST)
    return float(max(wanted, np.sqrt(area / MOST)))


def surface_samples(shape: Shape, pitch: float | None = None) -> SurfaceSamples:
    """Samples of a shape's surface, in its own frame.

    Args:
        shape: A solid or a mesh.
        pitch: Distance of neighbours [m], about; None: `pitch_for` the shape.

    Raises:
        InputError: A plane, which has no end.
    """
    pitch = pitch_for(shape) if pitch is None else pitch
    if isinstance(shape, Sphere):
        return _sphere(shape.radius, pitch)
    if isinstance(shape, Box):
        return _box(np.asarray(shape.size), pitch)
    if isinstance(shape, Cylinder):
        half = 0.5 * shape.length
        ends = [_disc(shape.radius, side * half, side, pitch) for side in (-1.0, 1.0)]
        return joined([_tube(shape.radius, shape.length, pitch), *ends])
    if isinstance(shape, Capsule):
        half = 0.5 * shape.length
        caps = [_half_sphere(shape.radius, side * half, side, pitch) for side in (-1.0, 1.0)]
        return joined([_tube(shape.radius, shape.length, pitch), *caps])
    if isinstance(shape, Plane):
        raise InputError("surface_samples: found a Plane, expected a solid or a mesh")
    return _triangles(*shape.triangles(), pitch)


def _pairs(length: float, pitch: float) -> Array:
    """Places (2k,) on (-length/2, length/2), of equal weights, exact for second moments (Gauss)."""
    cells = max(1, int(np.ceil(length / (2.0 * pitch) - 1e-9)))
    size = length / cells
    middle = (np.arange(cells) + 0.5) * size - 0.5 * length
    off = 0.5 * size / np.sqrt(3.0)
    return np.stack([middle - off, middle + off], axis=1).reshape(-1)


def _box(size: Array, pitch: float) -> SurfaceSamples:
    made = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        one, two = np.meshgrid(_pairs(size[u], pitch), _pairs(size[v], pitch), indexing="ij")
        points = np.zeros((one.size, 3))
        points[:, u], points[:, v] = one.reshape(-1), two.reshape(-1)
        areas = np.full(one.size, size[u] * size[v] / one.size)
        for side in (-1.0, 1.0):
            placed, normals = points.copy(), np.zeros((one.size, 3))
            placed[:, axis], normals[:, axis] = 0.5 * side * size[axis], side
            made.append(SurfaceSamples(placed, normals, areas))
    return joined(made)


def _around(count: int, turn: float = 0.0) -> Array:
    """Unit vectors (count, 2) around a circle."""
    angle = 2.0 * np.pi * (np.arange(count) + turn) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _tube(radius: float, length: float, pitch: float) -> SurfaceSamples:
    count = 4 * max(2, int(np.ceil(0.5 * np.pi * radius / pitch)))
    z = _pairs(length, pitch)
    ring = np.concatenate([_around(count, 0.5 * (i % 2)) for i in range(len(z))])
    normals = np.concatenate([ring, np.zeros((len(ring), 1))], axis=1)
    points = radius * normals
    points[:, 2] = np.repeat(z, count)
    areas = np.full(len(points), 2.0 * np.pi * radius * length / len(points))
    return SurfaceSamples(points, normals, areas)


def _disc(radius: float, z: float, side: float, pitch: float) -> SurfaceSamples:
    """Rings, each at the radius that has the second moment of its ring."""
    rings = max(2, int(np.ceil(radius / pitch - 1e-9)))
    edge = radius * np.arange(rings + 1) / rings
    points, areas = [], []
    for i, (inner, outer) in enumerate(pairwise(edge)):
        middle = np.sqrt(0.5 * (inner**2 + outer**2))
        count = 4 * max(1, round(0.5 * np.pi * middle / pitch))
        points.append(middle * _around(count, 0.5 * (i % 2)))
        areas.append(np.full(count, np.pi * (outer**2 - inner**2) / count))
    flat = np.concatenate(points)
    placed = np.column_stack([flat, np.full(len(flat), z)])
    normals = np.tile([0.0, 0.0, side], (len(flat), 1))
    return SurfaceSamples(placed, normals, np.concatenate(areas))


def _half_sphere(radius: float, z: float, side: float, pitch: float) -> SurfaceSamples:
    """Bands of equal angle; the area of each is by its height (Archimedes)."""
    bands = max(2, int(np.ceil(0.5 * np.pi * radius / pitch - 1e-9)))
    edge = np.sin(0.5 * np.pi * np.arange(bands + 1) / bands)
    normals, areas = [], []
    for i, (low, high) in enumerate(pairwise(edge)):
        # The second moment along z: mean of z^2 over the band.
        height = np.sqrt((low**2 + low * high + high**2) / 3.0)
        across = np.sqrt(1.0 - height**2)
        count = 4 * max(1, round(0.5 * np.pi * radius * across / pitch))
        ring = across * _around(count, 0.5 * (i % 2))
        normals.append(np.column_stack([ring, np.full(count, side * height)]))
        areas.append(np.full(count, 2.0 * np.pi * radius**2 * (high - low) / count))
    unit = np.concatenate(normals)
    points = radius * unit
    points[:, 2] += z
    return SurfaceSamples(points, unit, np.concatenate(areas))


def _sphere(radius: float, pitch: float) -> SurfaceSamples:
    """Middles of the triangles of a divided icosahedron, with the true areas of those."""
    area = 4.0 * np.pi * radius**2
    cuts = max(2, int(np.ceil(np.sqrt(area / 20.0) / pitch - 1e-9)))
    corners = _icosphere(cuts)
    middle = corners.sum(axis=1)
    unit = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    a, b, c = np.moveaxis(corners, 1, 0)
    # Solid angles of triangles (van Oosterom and Strackee).
    over = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c)))
    under = 1.0 + sum(np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a)))
    solid = 2.0 * np.arctan2(over, under)
    return SurfaceSamples(radius * unit, unit, radius**2 * solid)


def _icosphere(cuts: int) -> Array:
    """Corners (20 cuts^2, 3, 3) of triangles on the unit sphere."""
    golden = 0.5 * (1.0 + np.sqrt(5.0))
    vertices = [(0.0, s, t * golden) for s in (-1.0, 1.0) for t in (-1.0, 1.0)]
    corner = np.array([np.roll(v, k) for v in vertices for k in range(3)])
    corner /= np.linalg.norm(corner[0])
    near = 1.1 * np.sqrt(((corner[:, None] - corner[None]) ** 2).sum(-1) + 10.0 * np.eye(12)).min()
    close = np.linalg.norm(corner[:, None] - corner[None], axis=-1) < near
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if close[i, j] and close[j, k] and close[i, k]
    ]
    row, column = np.repeat(np.arange(cuts), cuts), np.tile(np.arange(cuts), cuts)
    up, down = row + column < cuts, row + column < cuts - 1
    weights = []
    for mask, offsets in ((up, ((0, 0), (1, 0), (0, 1))), (down, ((1, 0), (1, 1), (0, 1)))):
        at = [np.stack([row[mask] + a, column[mask] + b], axis=1) for a, b in offsets]
        weights.append(np.stack(at, axis=1))
    cell = np.concatenate(weights) / cuts
    full = np.concatenate([cell, 1.0 - cell.sum(axis=2, keepdims=True)], axis=2)
    made = np.concatenate([full @ corner[list(face)] for face in faces])
    result: Array = made / np.linalg.norm(made, axis=2, keepdims=True)
    return result


def _triangles(vertices: Array, faces: NDArray[np.int32], pitch: float) -> SurfaceSamples:
    """Three samples in each part of a triangle: exact for second moments."""
    a, b, c = np.moveaxis(np.asarray(vertices)[faces], 1, 0)
    across = np.cross(b - a, c - a)
    double = np.linalg.norm(across, axis=1)
    keep = double > 1e-14
    a, b, c, across, double = a[keep], b[keep], c[keep], across[keep], double[keep]
    # Halves of the longest edge, until the area is that of three samples.
    while True:
        big = 0.5 * double > 3.0 * pitch * pitch
        if not big.any():
            break
        p, q, r = a[big], b[big], c[big]
        size = np.stack([((p - q) ** 2).sum(1), ((q - r) ** 2).sum(1), ((r - p) ** 2).sum(1)])
        k = size.argmax(axis=0)
        corners = np.stack([p, q, r])
        rows = np.arange(len(k))
        one, two, three = (corners[(k + i) % 3, rows] for i in range(3))
        middle = 0.5 * (one + two)
        rest = ~big
        a = np.concatenate([a[rest], one, middle])
        b = np.concatenate([b[rest], middle, two])
        c = np.concatenate([c[rest], three, three])
        double = np.concatenate([double[rest], 0.5 * double[big], 0.5 * double[big]])
        across = np.concatenate([across[rest], across[big], across[big]])
    normal = across / np.linalg.norm(across, axis=1, keepdims=True)
    large = 0.5 * double > pitch * pitch
    p, q, r = a[large], b[large], c[large]
    points = [(4.0 * u + v + w) / 6.0 for u, v, w in ((p, q, r), (q, r, p), (r, p, q))]
    return joined(
        [
            SurfaceSamples(
                np.concatenate(points),
                np.tile(normal[large], (3, 1)),
                np.tile(double[large] / 6.0, 3),
            ),
            _merged((a + b + c)[~large] / 3.0, normal[~large], 0.5 * double[~large], pitch),
        ]
    )


def _merged(points: Array, normals: Array, areas: Array, pitch: float) -> SurfaceSamples:
    """Samples of small triangles, those of one square of `pitch` that face one way made one."""
    if not len(areas):
        return SurfaceSamples(points, normals, areas)
    axis = np.abs(normals).argmax(axis=1)
    rows = np.arange(len(axis))
    sign = np.sign(normals[rows, axis])
    cell = np.floor(points / pitch).astype(np.int64)
    keys = np.column_stack([axis, sign.astype(np.int64), cell])
    group = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    count = int(group.max()) + 1
    total: Array = np.bincount(group, areas, count).astype(np.float64)
    place, way = np.empty((count, 3)), np.empty((count, 3))
    for k in range(3):
        place[:, k] = np.bincount(group, areas * points[:, k], count) / total
        way[:, k] = np.bincount(group, areas * normals[:, k], count)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return SurfaceSamples(place, way, total)
