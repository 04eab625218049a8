"""Scaled shapes and objects, about their own origin; convex pieces are scaled, never recomputed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.colliders import convex_collider
from halfphysics.geometry.convex_decomposition import Cut, Decomposition
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.items import Object, Static, fixed
from halfphysics.scene.soft import Soft
from halfphysics.scene.trajectories import KinematicObject

Array = NDArray[np.float64]


def scaled_shape(shape: Shape, factor: float) -> Shape:
    """A shape `factor` times as large about its own origin; a plane is unchanged."""
    if isinstance(shape, Mesh):
        return Mesh(factor * shape.vertices, shape.faces)
    if isinstance(shape, Box):
        return Box([factor * s for s in shape.size])
    if isinstance(shape, Sphere):
        return Sphere(factor * shape.radius)
    if isinstance(shape, Capsule | Cylinder):
        return type(shape)(factor * shape.radius, factor * shape.length)
    if isinstance(shape, Plane):
        return shape
    raise InputError(
        f"scale: found a {type(shape).__name__}, expected a Box, Sphere, Capsule, Cylinder or Mesh"
    )


def scaled_static(static: Static, factor: float) -> Static:
    """A static `factor` times as large; its frame does not move."""
    return replace(
        static,
        shape=scaled_shape(static.shape, factor),
        soft=_scaled_soft(static.soft, factor),
        source=_scaled_source(static.source, factor),
    )


def scaled_object(item: Object, factor: float) -> Object:
    """An object `factor` times as large; its frame does not move.

    The mass is unchanged, the centre of mass scales with the factor, the inertia with its square.
    The deviation of the pieces from the mesh and the requested threshold scale with the factor.
    """
    made: dict[int, Any] = {}

    def scaled(shape: Any) -> Any:
        # A contact piece may be the same instance as the shape: keep them identical.
        if shape is not None and id(shape) not in made:
            made[id(shape)] = scaled_shape(shape, factor)
        return made.get(id(shape))

    decomposition = item.decomposition
    if decomposition is not None:
        decomposition = Decomposition(
            pieces=tuple(scaled(piece) for piece in decomposition.pieces),
            outside_mm=factor * decomposition.outside_mm,
            inside_mm=factor * decomposition.inside_mm,
            volume_percent=decomposition.volume_percent,
        )
    large = replace(
        item,
        shape=scaled(item.shape),
        visual=scaled(item.visual),
        source=_scaled_source(item.source, factor),
        decomposition=decomposition,
        soft=_scaled_soft(item.soft, factor),
        cut=_scaled_cut(item.cut, factor),
    )
    if isinstance(item, KinematicObject):
        return large
    even = np.array_equal(item.com, item.filling.centre)
    com = large.filling.centre if even else factor * item.com
    return weighing(replace(large, com=fixed(com)), item.mass)


def _scaled_soft(soft: Soft | None, factor: float) -> Soft | None:
    """A layer of the same foam, `factor` times as thick."""
    return None if soft is None else soft.of_thickness(factor * soft.thickness)


def weighing(item: Object, mass: float) -> Object:
    """An object of another mass [kg]; its inertia scales with the mass (uniform density)."""
    return replace(item, mass=mass, inertia=fixed(mass * item.filling.unit_inertia()))


def lowest(item: Static | Object) -> float:
    """Height of the lowest point of the collision shape above the origin [m]; a plane: -inf."""
    pieces = item.pieces if isinstance(item, Object) else (item.shape,)
    if isinstance(item, Object) and item.soft is not None:
        pieces = (item.true_shape,)  # its pieces are those of the frame
    up = rot.to_matrix(item.quaternion)[2]  # of its axes in the world
    return min(_lowest(shape, up) for shape in pieces)


def _lowest(shape: Shape, up: Array) -> float:
    if isinstance(shape, Plane):
        return -np.inf
    if isinstance(shape, Mesh):
        return float((shape.vertices @ up).min())
    collider = convex_collider(shape)
    disc = float(np.linalg.norm(collider.rim))
    tilt = 0.0
    if disc > 0.0:
        along = float(collider.rim @ up) / disc
        tilt = disc * float(np.sqrt(max(0.0, 1.0 - along * along)))
    return float((collider.vertices @ up).min()) - collider.radius - tilt


def _scaled_source(source: MeshSource | None, factor: float) -> MeshSource | None:
    return None if source is None else replace(source, scale=factor * source.scale)


def _scaled_cut(cut: Cut, factor: float) -> Cut:
    return cut if cut.pieces == "given" else replace(cut, threshold=factor * cut.threshold)
