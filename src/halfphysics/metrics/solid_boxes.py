"""Boxes around the shapes of a scene, and bounds of distances that they give."""

from __future__ import annotations

import numpy as np

from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.metrics.argument_checks import Array


def distance_bound(shape: Shape, places: Array, turns: Array, middle: Array, half: Array) -> Array:
    """A lower bound of distances (t, G) [m] of boxes from a solid; -inf where they may meet.

    Args:
        shape: The solid's shape.
        places: Its positions (t or 1, 3) [m].
        turns: Its rotation matrices (t or 1, 3, 3).
        middle, half: Middles and half sizes of boxes along the world's axes (t, G, 3) [m].

    Raises:
        TypeError: An unknown kind of shape.
    """
    if isinstance(shape, Plane):
        normal = turns @ np.asarray(shape.normal)
        offset = shape.offset + np.einsum("tj,tj->t", normal, places)
        reach = np.einsum("tgj,tj->tg", half, np.abs(normal))
        gap = np.einsum("tgj,tj->tg", middle, normal) - reach - offset[:, None]
    else:
        low, high = _box_of(shape)
        centre = places + turns @ (0.5 * (low + high))
        size = np.abs(turns) @ (0.5 * (high - low))
        apart = np.abs(middle - centre[:, None]) - half - size[:, None]
        gap = np.linalg.norm(np.maximum(apart, 0.0), axis=-1)
    result: Array = np.where(gap <= 0.0, -np.inf, gap)
    return result


def _box_of(shape: Shape) -> tuple[Array, Array]:
    """Corners of a box around a shape, in its frame."""
    if isinstance(shape, Mesh):
        return shape.query.bounds[0], shape.query.bounds[1]
    if isinstance(shape, Box):
        half = 0.5 * np.asarray(shape.size)
    elif isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    elif isinstance(shape, Capsule | Cylinder):
        cap = shape.radius if isinstance(shape, Capsule) else 0.0
        half = np.array([shape.radius, shape.radius, 0.5 * shape.length + cap])
    else:
        raise TypeError(f"shape: found {type(shape).__name__}, expected one of halfphysics")
    return -half, half
