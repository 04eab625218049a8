"""Intervals of parallel rays inside the shapes of a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.parallel_rays import crossings
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.metrics.argument_checks import Array
from halfphysics.metrics.spans import Spans

Ints = NDArray[np.int64]

#: Shift of the grid, so that a shape symmetric about the origin is not aligned with it.
_SHIFT = np.array([0.1871, 0.3178, 0.0])


@dataclass(frozen=True, eq=False)
class Grid:
    """Rays along z, `pitch` [m] apart: the grid is turned (3, 3) about z, in units of pitch."""

    pitch: float
    turn: Array

    def of(self, points: Array) -> Array:
        """World to grid: (..., 3)."""
        result: Array = points @ self.turn.T / self.pitch + _SHIFT
        return result

    def world(self, points: Array) -> Array:
        """Grid to world: (..., 3)."""
        result: Array = self.pitch * (points - _SHIFT) @ self.turn
        return result


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape at a pose in the world: position (3,), quaternion (4,)."""

    shape: Shape
    position: Array
    quaternion: Array

    def inside(self, grid: Grid, skin: Spans) -> Spans:
        """Intervals of the rays of a skin's spans that are inside the shape, within the spans.

        Exact along each ray; for a mesh that is not closed, every span is sampled at the middles
        of steps of at most the pitch.
        """
        shape = self.shape
        if isinstance(shape, Mesh) and not shape.closed:
            return self._sampled(shape, grid, skin)
        window = skin.ray.min(axis=0), skin.ray.max(axis=0)
        if not isinstance(shape, Plane | Sphere | Capsule | Cylinder):
            vertices, faces = shape.triangles()
            placed = grid.of(vertices @ rot.to_matrix(self.quaternion).T + self.position)
            return Spans.of_crossings(*crossings(placed, faces.astype(np.int64), window))
        ray = np.unique(skin.ray, axis=0)
        foot = np.concatenate([ray + 0.5, np.zeros((len(ray), 1))], axis=1)
        turn = rot.to_matrix(self.quaternion)
        start = (grid.world(foot) - self.position) @ turn
        along = grid.pitch * grid.turn[2] @ turn  # one step of the grid
        reach = float(skin.bottom.min()) - 1.0, float(skin.top.max()) + 1.0
        pieces = [
            Spans(ray[low < high], low[low < high], high[low < high])
            for low, high in _through(shape, start, along, reach)
        ]
        return Spans.union(pieces)

    def _sampled(self, mesh: Mesh, grid: Grid, skin: Spans) -> Spans:
        length = skin.top - skin.bottom
        count = np.maximum(np.ceil(length), 1.0).astype(np.int64)
        which = np.repeat(np.arange(len(count)), count)
        rank = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
        step = (length / count)[which]
        bottom = skin.bottom[which] + rank * step
        middle = np.column_stack([skin.ray[which] + 0.5, bottom + 0.5 * step])
        local = (grid.world(middle) - self.position) @ rot.to_matrix(self.quaternion)
        within = mesh.depth(local) > 0.0
        return Spans(skin.ray[which][within], bottom[within], (bottom + step)[within])


def _through(
    shape: Shape, start: Array, along: Array, reach: tuple[float, float]
) -> list[tuple[Array, Array]]:
    """Pieces (low (n,), high (n,)) of lines start (n, 3) + t along (3,) in a shape, low < high."""
    full = np.full(len(start), reach[0]), np.full(len(start), reach[1])
    if isinstance(shape, Plane):
        normal = np.asarray(shape.normal)
        return [_below(start @ normal - shape.offset, float(along @ normal), full)]
    if isinstance(shape, Sphere):
        return [_ball(start, along, np.zeros(3), shape.radius)]
    if not isinstance(shape, Capsule | Cylinder):
        raise InputError(
            f"penetrating volume: found a {type(shape).__name__}, expected a plane, box, sphere, "
            "capsule, cylinder or mesh"
        )
    half = np.array([0.0, 0.0, 0.5 * shape.length])
    side = _quadratic(
        float(along[:2] @ along[:2]),
        start[:, :2] @ along[:2],
        (start[:, :2] ** 2).sum(axis=1) - shape.radius**2,
        full,
    )
    tube = _below(start[:, 2] - half[2], float(along[2]), side)
    pieces = [_below(-start[:, 2] - half[2], -float(along[2]), tube)]
    if isinstance(shape, Capsule):
        pieces += [_ball(start, along, sign * half, shape.radius) for sign in (-1.0, 1.0)]
    return pieces


def _below(at: Array, slope: float, within: tuple[Array, Array]) -> tuple[Array, Array]:
    """The intervals within `within` in which at (n,) + t slope < 0."""
    low, high = within
    if abs(slope) < 1e-15:
        return low, np.where(at < 0.0, high, low)
    t = -at / slope
    return (low, np.minimum(high, t)) if slope > 0.0 else (np.maximum(low, t), high)


def _ball(start: Array, along: Array, centre: Array, radius: float) -> tuple[Array, Array]:
    off = start - centre
    none = np.zeros(len(start)), np.zeros(len(start))
    return _quadratic(float(along @ along), off @ along, (off**2).sum(axis=1) - radius**2, none)


def _quadratic(a: float, b: Array, c: Array, otherwise: tuple[Array, Array]) -> tuple[Array, Array]:
    """The interval in which a t^2 + 2 b t + c < 0; `otherwise` if a is 0 and c < 0."""
    if a < 1e-30:
        low, high = otherwise
        return low, np.where(c < 0.0, high, low)
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    return (-b - root) / a, (-b + root) / a
