"""Signed distances of points from the surface of a shape, with the outward normal there.

The distance is negative inside the solid. A closed mesh is a solid. An open one is a sheet with
two sides: the side of a point is that of a second point, its `inner` one (the middle of the part to
which the point belongs), so that a foot that has sunk into a floor of one layer is under it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere

Array = NDArray[np.float64]

#: Beside an edge the normal turns from that of the face to the direction of the point over this
#: distance [m].
ROUNDING = 1e-3


def surface_distance(shape: Shape, points: Array, inner: Array) -> tuple[Array, Array]:
    """Signed distances and normals.

    Args:
        shape: Any shape of a scene.
        points: In the shape's frame (n, 3) [m].
        inner: A point inside the body for each of them (n, 3); read for open meshes only.

    Returns:
        Distances (n,) [m], negative inside, and outward unit normals (n, 3), which lead from the
        nearest point of the surface: it is ``points - distance * normal``, but near the edges of
        meshes (`ROUNDING`).

    Raises:
        InputError: A shape of another kind.
    """
    if isinstance(shape, Plane):
        normal = np.asarray(shape.normal)
        return np.einsum("ni,i->n", points, normal) - shape.offset, np.broadcast_to(
            normal, points.shape
        )
    if isinstance(shape, Box):
        return _of_box(points, 0.5 * np.asarray(shape.size))
    if isinstance(shape, Sphere):
        return _of_point(points, shape.radius)
    if isinstance(shape, Capsule):
        half = 0.5 * shape.length
        axis = np.zeros_like(points)
        axis[:, 2] = np.clip(points[:, 2], -half, half)
        return _of_point(points - axis, shape.radius)
    if isinstance(shape, Cylinder):
        return _of_cylinder(points, shape)
    if isinstance(shape, Mesh):
        return _of_mesh(points, inner, shape)
    raise InputError(f"support: found {type(shape).__name__}, expected a shape of a scene")


def _of_point(points: Array, radius: float) -> tuple[Array, Array]:
    """Of a sphere about the origin; at its centre the normal is up."""
    length = np.linalg.norm(points, axis=1)
    safe = np.where(length > 0.0, length, 1.0)[:, None]
    return length - radius, np.where(length[:, None] > 0.0, points / safe, (0.0, 0.0, 1.0))


def _of_box(points: Array, half: Array) -> tuple[Array, Array]:
    beyond = np.abs(points) - half
    sign = np.where(points < 0.0, -1.0, 1.0)
    outward = np.maximum(beyond, 0.0)
    outside = np.linalg.norm(outward, axis=1)
    deepest = beyond.max(axis=1)
    face = np.eye(3)[beyond.argmax(axis=1)]
    is_out = outside > 0.0
    direction = np.where(is_out[:, None], outward / np.where(is_out, outside, 1.0)[:, None], face)
    return np.where(is_out, outside, deepest), sign * direction


def _of_cylinder(points: Array, shape: Cylinder) -> tuple[Array, Array]:
    """As a box in the plane of radius and axis."""
    radius = np.hypot(points[:, 0], points[:, 1])
    flat = np.stack([radius, np.zeros_like(radius), points[:, 2]], axis=1)
    half = np.array([shape.radius, 1.0, 0.5 * shape.length])
    distance, normal = _of_box(flat, half)
    safe = np.where(radius > 0.0, radius, 1.0)
    x = np.where(radius > 0.0, points[:, 0] / safe, 1.0)
    y = np.where(radius > 0.0, points[:, 1] / safe, 0.0)
    return distance, np.stack([normal[:, 0] * x, normal[:, 0] * y, normal[:, 2]], axis=1)


def _of_mesh(points: Array, inner: Array, mesh: Mesh) -> tuple[Array, Array]:
    distance, face, nearest = mesh.query.closest(points)
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[face]], 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 0.0, normal / np.where(length > 0.0, length, 1.0), (0.0, 0.0, 1.0))
    if mesh.closed:
        inside = mesh.query.inside(points)
    else:
        side = np.einsum("ni,ni->n", inner - nearest, normal)
        normal = np.where(side[:, None] < 0.0, -normal, normal)
        inside = np.einsum("ni,ni->n", points - nearest, normal) < 0.0
    outward = np.where(inside[:, None], nearest - points, points - nearest) + ROUNDING * normal
    size = np.linalg.norm(outward, axis=1, keepdims=True)
    outward = np.where(size > 1e-12, outward / np.where(size > 1e-12, size, 1.0), normal)
    return np.where(inside, -distance, distance), outward
