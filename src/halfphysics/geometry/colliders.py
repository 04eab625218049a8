"""Collision geometry of a shape: a convex hull of points, swept and rounded."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.geometry.shapes import Shape

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ConvexCollider:
    """Hull of `vertices` (n, 3) grown by `radius` [m]; outward unit face `normals` (m, 3).

    A sphere is one vertex, a capsule two, a box eight. Before it is grown the hull is swept by a
    disc across `rim` (3,), of that length [m]: a cylinder is two vertices and a disc. The normals
    serve only to find the way out of an overlap.
    """

    vertices: Array
    normals: Array
    radius: float = 0.0
    rim: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def arrays(self) -> tuple[Array, Array, float, Array]:
        """The last arguments of the core's add_shape() and add_hull(), in their order."""
        return self.vertices, self.normals, self.radius, self.rim

    def moved(self, rotation: Array, position: Array) -> ConvexCollider:
        """The same collider under a rotation (3, 3) and a shift (3,)."""
        return ConvexCollider(
            vertices=np.ascontiguousarray(self.vertices @ rotation.T + position),
            normals=np.ascontiguousarray(self.normals @ rotation.T),
            radius=self.radius,
            rim=rotation @ self.rim,
        )


def hull_collider(points: ArrayLike) -> ConvexCollider:
    """Collider of the convex hull of points (n, 3), n >= 1; flat and thin sets are allowed."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.ascontiguousarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InputError(f"points: found shape {points.shape}, expected (n, 3) with n >= 1")
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        # Fewer than four points, or all in a plane: every point counts, no face has an inside.
        return ConvexCollider(vertices=points, normals=np.zeros((0, 3)))
    normals = np.unique(np.round(hull.equations[:, :3], 6), axis=0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return ConvexCollider(vertices=points[np.sort(hull.vertices)], normals=normals)


def convex_collider(shape: Shape) -> ConvexCollider:
    """Collider of a primitive or convex mesh, in the shape's own frame.

    Raises:
        InputError: The shape is a plane, which is a half-space and no hull.
    """
    from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Sphere

    axes = np.concatenate([np.eye(3), -np.eye(3)])
    if isinstance(shape, Box):
        return ConvexCollider(vertices=np.array(shape.convex_vertices()), normals=axes)
    if isinstance(shape, Sphere):
        return ConvexCollider(
            vertices=np.zeros((1, 3)), normals=np.zeros((0, 3)), radius=shape.radius
        )
    if isinstance(shape, Capsule):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * shape.length
        return ConvexCollider(vertices=ends, normals=np.zeros((0, 3)), radius=shape.radius)
    if isinstance(shape, Cylinder):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * shape.length
        rim = np.array([0.0, 0.0, shape.radius])
        return ConvexCollider(vertices=ends, normals=axes[[2, 5]], rim=rim)
    if isinstance(shape, Mesh):
        return hull_collider(shape.convex_vertices())
    raise InputError(
        f"{type(shape).__name__} is no convex solid; "
        "expected Box, Sphere, Capsule, Cylinder or Mesh"
    )
