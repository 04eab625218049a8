"""`near`, slowly, in plain numpy: every vertex against every solid and triangle.

Equation by equation, nothing left out: `tests/labels/test_reference.py` holds both equal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.labels.bounding_spheres import part_balls
from halfphysics.labels.item_solids import ItemSolids, Solid
from halfphysics.labels.proximity import Near, Target
from support.references.mesh_queries import closest_reference, winding_reference

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


def solid_distance(solid: Solid, points: Array) -> Array:
    """Distances (n,) [m] of points (n, 3) in the object's frame from a solid, 0 inside it."""
    p, shape = (points - solid.position) @ solid.turn, solid.shape
    if isinstance(shape, Mesh):
        return _mesh_distance(shape, solid.surface, solid.filled, p)
    distance: Array
    if isinstance(shape, Plane):
        distance = p @ np.asarray(shape.normal) - shape.offset
    elif isinstance(shape, Box):
        outside = np.maximum(np.abs(p) - 0.5 * np.asarray(shape.size), 0.0)
        distance = np.linalg.norm(outside, axis=1)
    elif isinstance(shape, Sphere):
        distance = np.linalg.norm(p, axis=1) - shape.radius
    elif isinstance(shape, Capsule):
        half = 0.5 * shape.length
        axis = np.zeros_like(p)
        axis[:, 2] = np.clip(p[:, 2], -half, half)
        distance = np.linalg.norm(p - axis, axis=1) - shape.radius
    elif isinstance(shape, Cylinder):
        side = np.maximum(np.hypot(p[:, 0], p[:, 1]) - shape.radius, 0.0)
        distance = np.hypot(side, np.maximum(np.abs(p[:, 2]) - 0.5 * shape.length, 0.0))
    else:
        raise TypeError(f"no distance from a {type(shape).__name__}")
    return np.maximum(distance, 0.0)


def _mesh_distance(shape: Mesh, surface: bool, filled: bool, points: Array) -> Array:
    """Distances (n,) [m] of points (n, 3) from a mesh's surface, or from the solid in it or in its
    hull."""
    mesh = shape if surface else shape.hull
    distance = closest_reference(points, mesh.vertices, mesh.faces)[0]
    if surface and not filled:
        return distance
    return np.where(winding_reference(points, mesh.vertices, mesh.faces) > 0.5, 0.0, distance)


def near_reference(body: Body, motion: Motion, target: Target) -> tuple[Near, Near]:
    """As `near` for one target."""
    skin, surface = [], []
    for frame, posed in enumerate(body.vertices(motion)):
        of_skin, of_surface = _in_frame(body, posed, target, frame)
        skin.append(of_skin)
        surface.append(of_surface)
    return Near.joined(skin), Near.joined(surface)


def _in_frame(body: Body, posed: Array, target: Target, frame: int) -> tuple[Near, Near]:
    item, part = target.item, part_balls(body).part
    local = _local(item, posed, frame)
    distance = np.min([solid_distance(solid, local) for solid in item.solids], axis=0)
    vertex = np.flatnonzero((distance <= target.reach) & item.parts[part])
    skin = Near(np.full(len(vertex), frame, np.int32), vertex.astype(np.int32), distance[vertex])
    if target.surface is None:
        return skin, Near.joined([])
    faces = body.faces[item.parts[part[body.faces]].all(axis=1)]
    distance, face, point = closest_reference(target.surface.vertices, local, faces)
    if item.soft:
        inside = winding_reference(target.surface.vertices, local, body.faces) > 0.5
        distance = np.where(inside, 0.0, distance)
    vertex = np.flatnonzero(distance <= target.reach)
    corners = faces[face[vertex]]
    apart = np.linalg.norm(local[corners] - point[vertex, None], axis=2).argmin(axis=1)
    at = min(frame, len(item.position) - 1)
    return skin, Near(
        np.full(len(vertex), frame, np.int32),
        vertex.astype(np.int32),
        distance[vertex],
        corners[np.arange(len(vertex)), apart].astype(np.int32),
        point[vertex] @ item.turn[at].T + item.position[at],
    )


def _local(item: ItemSolids, points: Array, frame: int) -> Array:
    at = min(frame, len(item.position) - 1)
    result: Array = (points - item.position[at]) @ item.turn[at]
    return result
