"""Primitive shapes: plane, box, sphere, capsule, cylinder; `Mesh` is the triangle mesh.

All are frozen, checked when made, in metres and centred on their own origin. An item of a scene (a
shape with a pose and a material) is in `halfphysics.scene.items`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.validation import number, vector
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.shape_base import Array, MassProperties, Shape, Triangles

__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "MassProperties",
    "Mesh",
    "MeshSource",
    "Plane",
    "Shape",
    "Sphere",
]

#: Half the side of the square that represents a plane in pictures [m].
PLANE_HALF_EXTENT = 10.0
#: A normal whose square is this near to one has unit length: rounding.
_UNIT = 1e-15

_SEGMENTS = 32  # around the axis of round shapes, where they are triangulated


@dataclass(frozen=True)
class Plane(Shape):
    """A half space: solid where normal . x < offset. The floor is ``Plane()``.

    normal (3,), scaled to unit length; offset [m] along it. Raises `InputError`.
    """

    normal: Sequence[float] = (0.0, 0.0, 1.0)
    offset: float = 0.0

    def __post_init__(self) -> None:
        normal = vector(self.normal, "Plane: normal")
        length = np.linalg.norm(normal)
        if not length > 1e-12:
            raise InputError("Plane: normal has no length, expected a direction such as (0, 0, 1)")
        if abs(normal @ normal - 1.0) > _UNIT:  # so that a unit normal is kept to the last bit
            normal = normal / length
        object.__setattr__(self, "normal", tuple(normal.tolist()))
        object.__setattr__(self, "offset", number(self.offset, "Plane: offset", unit="m"))

    @property
    def volume(self) -> float:
        """Infinite."""
        return float("inf")

    def triangles(self) -> Triangles:
        """A square of side 20 m about the point of the plane nearest the origin."""
        normal = np.asarray(self.normal)
        side = np.eye(3)[np.argmin(np.abs(normal))]
        u = np.cross(normal, side)
        u /= np.linalg.norm(u)
        v = np.cross(normal, u)
        corners = [-u - v, u - v, u + v, v - u]
        vertices = self.offset * normal + PLANE_HALF_EXTENT * np.array(corners)
        return vertices, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """Distance (n,) [m] of points (n, 3) under the plane, 0 above."""
        result: Array = np.maximum(self.offset - as_array(points) @ np.asarray(self.normal), 0.0)
        return result


@dataclass(frozen=True)
class Box(Shape):
    """A box of full extents `size` (3,) [m] along its axes. Raises `InputError`."""

    size: Sequence[float]

    def __post_init__(self) -> None:
        size = vector(self.size, "Box: size (full extents)", unit="m").tolist()
        for value in size:
            number(value, "Box: size", above=0.0, unit="m")
        object.__setattr__(self, "size", tuple(size))

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return float(np.prod(self.size))

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) at 1 kg [m^2]."""
        square = np.square(self.size)
        return np.diag((square.sum() - square) / 12.0)

    def convex_vertices(self) -> Array:
        """The eight corners (8, 3) [m]."""
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        result: Array = 0.5 * signs * np.asarray(self.size)
        return result

    def triangles(self) -> Triangles:
        """Eight corners, twelve triangles."""
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        faces = [f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]
        return self.convex_vertices(), np.array(faces, dtype=np.int32)

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """Distance (n,) [m] of points (n, 3) to the nearest side, 0 outside."""
        gap = 0.5 * np.asarray(self.size) - np.abs(as_array(points))
        # Column by column: the smallest along so short an axis takes four times as long.
        result: Array = np.maximum(
            np.minimum(np.minimum(gap[..., 0], gap[..., 1]), gap[..., 2]), 0.0
        )
        return result


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball of `radius` [m]. Raises `InputError`."""

    radius: float

    def __post_init__(self) -> None:
        radius = number(self.radius, "Sphere: radius", above=0.0, unit="m")
        object.__setattr__(self, "radius", radius)

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) at 1 kg [m^2]."""
        return 0.4 * self.radius**2 * np.eye(3)

    def triangles(self) -> Triangles:
        """Rings of latitude, corners on the sphere."""
        return _revolve(*_arc(self.radius, 0.0))

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """Distance (n,) [m] of points (n, 3) to the surface, 0 outside."""
        result: Array = np.maximum(self.radius - np.linalg.norm(as_array(points), axis=-1), 0.0)
        return result


@dataclass(frozen=True)
class _Round(Shape):
    radius: float
    length: float

    def __post_init__(self) -> None:
        name = type(self).__name__
        for key in ("radius", "length"):
            value = number(getattr(self, key), f"{name}: {key}", above=0.0, unit="m")
            object.__setattr__(self, key, value)


@dataclass(frozen=True)
class Capsule(_Round):
    """A capsule along z: `radius` [m], `length` [m] without the caps. Raises `InputError`."""

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return np.pi * self.radius**2 * (self.length + 4.0 / 3.0 * self.radius)

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) at 1 kg [m^2]: a cylinder and two half balls."""
        r, l = self.radius, self.length
        tube = l / (l + 4.0 / 3.0 * r)  # share of the mass
        caps = 1.0 - tube
        along = tube * r * r / 2.0 + caps * 0.4 * r * r
        across = tube * (3.0 * r * r + l * l) / 12.0
        across += caps * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * l * r)
        return np.diag([across, across, along])

    def triangles(self) -> Triangles:
        """Rings of latitude, corners on the capsule."""
        return _revolve(*_arc(self.radius, 0.5 * self.length))

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """Distance (n,) [m] of points (n, 3) to the surface, 0 outside."""
        p = np.array(array_of(points), dtype=np.float64)
        half = 0.5 * self.length
        p[..., 2] -= np.clip(p[..., 2], -half, half)
        result: Array = np.maximum(self.radius - np.linalg.norm(p, axis=-1), 0.0)
        return result


@dataclass(frozen=True)
class Cylinder(_Round):
    """A cylinder along z: `radius` [m], `length` [m] from end to end. Raises `InputError`."""

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return np.pi * self.radius**2 * self.length

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) at 1 kg [m^2]."""
        across = (3.0 * self.radius**2 + self.length**2) / 12.0
        return np.diag([across, across, 0.5 * self.radius**2])

    def triangles(self) -> Triangles:
        """A prism with its corners on the rims."""
        half = 0.5 * self.length
        return _revolve(np.array([0.0, self.radius, self.radius, 0.0]), half * _ENDS)

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """Distance (n,) [m] of points (n, 3) to the surface, 0 outside."""
        p = np.asarray(array_of(points), dtype=np.float64)
        side = self.radius - np.hypot(p[..., 0], p[..., 1])
        return np.maximum(np.minimum(side, 0.5 * self.length - np.abs(p[..., 2])), 0.0)


_ENDS = np.array([-1.0, -1.0, 1.0, 1.0])


def _arc(radius: float, half: float) -> tuple[Array, Array]:
    """Profile of a capsule (half the length of its tube; 0: a sphere), from south to north."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _SEGMENTS // 2 + 1)
    r, z = radius * np.cos(angle), radius * np.sin(angle)
    r[0] = r[-1] = 0.0
    if half == 0.0:
        return r, z
    middle = len(angle) // 2
    r = np.concatenate([r[: middle + 1], r[middle:]])
    return r, np.concatenate([z[: middle + 1] - half, z[middle:] + half])


def _revolve(r: Array, z: Array) -> Triangles:
    """Closed surface of a profile (k,) turned about z; its first and last point on the axis."""
    angle = 2.0 * np.pi * np.arange(_SEGMENTS) / _SEGMENTS
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    rings = len(r) - 2
    body = np.empty((rings, _SEGMENTS, 3))
    body[..., :2] = r[1:-1, None, None] * ring
    body[..., 2] = z[1:-1, None]
    vertices = np.concatenate([body.reshape(-1, 3), [[0.0, 0.0, z[0]], [0.0, 0.0, z[-1]]]])
    j = np.arange(_SEGMENTS)
    k = (j + 1) % _SEGMENTS
    south, north = rings * _SEGMENTS, rings * _SEGMENTS + 1
    faces = [np.stack([np.full_like(j, south), k, j], axis=-1)]
    for i in range(rings - 1):
        low, high = i * _SEGMENTS, (i + 1) * _SEGMENTS
        faces.append(np.stack([low + j, low + k, high + k], axis=-1))
        faces.append(np.stack([low + j, high + k, high + j], axis=-1))
    last = (rings - 1) * _SEGMENTS
    faces.append(np.stack([last + j, last + k, np.full_like(j, north)], axis=-1))
    return vertices, np.concatenate(faces).astype(np.int32)
