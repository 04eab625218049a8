"""A clean, closed surface around what a mesh encloses: the input that convex decomposition needs.

A scan has many more triangles than contact needs and crosses itself where it is noisy. Here its
signed distance (negative inside, where the winding number is over 0.5, as in every query about the
inside of a mesh) is sampled on a grid near the surface, and the zero level is cut out by surface
nets (Gibson 1998): one vertex in every cell that the surface crosses, at the mean of the crossings
of the cell's edges, and a quad about every edge that crosses it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: Cells of the coarsest level of the search for the surface, and of the finer ones.
_LEVELS = (8, 4, 2)
#: Free cells around the mesh, so that every crossing edge has four cells around it.
_MARGIN = 2
#: Most points of a grid: 4 bytes each.
_MOST_POINTS = 2**25
#: How many cells of size h a surface of area A crosses: 1.5 A / h^2, over all directions.
_CROSSED = 1.5


def cell_for(mesh: Mesh, quads: int, least: float) -> float:
    """The size of cells [m] at which the surface has about so many quads, at least `least`."""
    size = math.sqrt(_CROSSED * _area(mesh) / quads)
    box = float(np.prod(np.ptp(mesh.vertices, axis=0)))
    return float(max(size, least, (box / _MOST_POINTS) ** (1.0 / 3.0)))


def remeshed(mesh: Mesh, cell: float) -> Mesh:
    """The surface of what a closed `mesh` encloses, from cells of size `cell` [m].

    Details and walls thinner than a cell are lost: measure what comes of it.

    Raises:
        InputError: Nothing is left.
    """
    low, high = mesh.query.bounds
    count = np.ceil((high - low) / cell).astype(int) + 1 + 2 * _MARGIN
    count = -(-count // _LEVELS[0]) * _LEVELS[0] + 1
    if math.prod(count.tolist()) > 2 * _MOST_POINTS:
        raise InputError(f"Mesh: too large for cells of {cell:g} m")
    origin = low - _MARGIN * cell
    value = _distances(mesh, origin, cell, count)
    vertices, faces = _surface(value)
    if not len(faces):
        raise InputError("Mesh: encloses nothing")
    return Mesh(origin + cell * vertices, faces.astype(np.int32))


def _area(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _distances(mesh: Mesh, origin: Array, cell: float, count: NDArray[np.int_]) -> Array:
    """Signed distances on a grid (nx, ny, nz) of points, NaN away from the surface.

    Blocks of cells whose middle is farther from the surface than their corners are left out, from
    coarse to fine.
    """
    coarse = _LEVELS[0]
    axes = [np.arange(0, n - 1, coarse) for n in count]
    corner = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    halves = np.stack(np.meshgrid(*[[0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for size in _LEVELS:
        away = mesh.query.closest(origin + cell * (corner + 0.5 * size))[0]
        # A cell more on each side: the cells around a crossing edge.
        corner = corner[away <= cell * math.sqrt(3.0) * (0.5 * size + 1.0)]
        if size > _LEVELS[-1]:
            corner = (corner[:, None] + size // 2 * halves).reshape(-1, 3)
    inner = np.stack(np.meshgrid(*[range(_LEVELS[-1] + 1)] * 3, indexing="ij"), axis=-1)
    places = (corner[:, None] + inner.reshape(-1, 3)).reshape(-1, 3)
    flat = np.unique(np.ravel_multi_index(tuple(places.T), tuple(count)))
    points = origin + cell * np.stack(np.unravel_index(flat, tuple(count)), axis=1)
    away = mesh.query.closest(points)[0]
    value = np.full(math.prod(count.tolist()), np.nan)
    value[flat] = np.where(mesh.query.inside(points), -away, away)
    return value.reshape(tuple(count))


def _surface(value: Array) -> tuple[Array, NDArray[np.int64]]:
    """Vertices (V, 3), in cells, and outward triangles (F, 3) of the zero level."""
    cells = tuple(n - 1 for n in value.shape)
    touched, crossings = [], []
    for axis in range(3):
        along = np.eye(3, dtype=int)[axis]
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        here, there = (
            np.moveaxis(np.moveaxis(value, axis, 0)[part], 0, axis)
            for part in (slice(None, -1), slice(1, None))
        )
        known = np.isfinite(here) & np.isfinite(there)
        at = np.argwhere(known & ((here < 0.0) != (there < 0.0)))
        a, b = here[tuple(at.T)], there[tuple(at.T)]
        place = at + (a / (a - b))[:, None] * along
        around = np.stack([at - u - v, at - v, at, at - u], axis=1)
        around[b < 0.0] = around[b < 0.0, ::-1]
        cell = np.ravel_multi_index(tuple(np.moveaxis(around, -1, 0)), cells)
        touched.append(cell)
        crossings.append(np.repeat(place, 4, axis=0))
    quads = np.concatenate(touched)
    _, index = np.unique(quads, return_inverse=True)
    index = index.reshape(quads.shape)
    total = np.stack(
        [np.bincount(index.ravel(), column) for column in np.concatenate(crossings).T], axis=1
    )
    vertices = total / np.bincount(index.ravel())[:, None]
    return vertices, np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]])
