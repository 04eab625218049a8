"""Convex shapes as MuJoCo geoms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere

if TYPE_CHECKING:
    from halfphysics.geometry.shapes import Shape

Array = NDArray[np.float64]


def add_geom(
    spec: Any,
    body: Any,
    name: str,
    shape: Shape,
    position: Array,
    quaternion: Array,
    **options: Any,
) -> None:
    """Add a shape to a body of a `mujoco.MjSpec`; of a mesh, its convex hull.

    Args:
        spec: The `mujoco.MjSpec`.
        body: The `mujoco.MjsBody`.
        name: Of the geom, and of its mesh where it needs one.
        shape: What to add.
        position, quaternion: Of the shape's frame in the body's, (3,) [m] and (4,).
        options: Of `MjsBody.add_geom`.
    """
    if isinstance(shape, Mesh):
        add_points(spec, body, name, shape.vertices, position, quaternion, **options)
        return
    if isinstance(shape, Plane):
        position, quaternion = _plane_pose(shape, position, quaternion)
    body.add_geom(name=name, pos=position, quat=quaternion, **_primitive(shape), **options)


def add_points(
    spec: Any,
    body: Any,
    name: str,
    points: Array,
    position: Array,
    quaternion: Array,
    **options: Any,
) -> None:
    """As `add_geom`, of the hull of points (n, 3) [m]."""
    import mujoco

    spec.add_mesh(
        name=name,
        uservert=np.ravel(points),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
    )
    body.add_geom(
        name=name, type=_type("MESH"), meshname=name, pos=position, quat=quaternion, **options
    )


def _type(name: str) -> Any:
    import mujoco

    return getattr(mujoco.mjtGeom, f"mjGEOM_{name}")


def _plane_pose(plane: Plane, position: Array, quaternion: Array) -> tuple[Array, Array]:
    """Place of MuJoCo's plane, which is z = 0 of its own frame."""
    normal = rot.rotate(quaternion, np.asarray(plane.normal, dtype=np.float64))
    axis = np.array([-normal[1], normal[0], 0.0])  # z cross normal
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    turn = rot.exp(np.arctan2(sine, normal[2]) * axis)
    return position + plane.offset * normal, turn


def _primitive(shape: Shape) -> dict[str, Any]:
    """Type and size of a primitive."""
    if isinstance(shape, Plane):
        return {"type": _type("PLANE"), "size": [0.0, 0.0, 1.0]}
    if isinstance(shape, Box):
        return {"type": _type("BOX"), "size": 0.5 * np.asarray(shape.size)}
    if isinstance(shape, Sphere):
        return {"type": _type("SPHERE"), "size": [shape.radius, 0.0, 0.0]}
    if isinstance(shape, Capsule | Cylinder):
        kind = "CAPSULE" if isinstance(shape, Capsule) else "CYLINDER"
        return {"type": _type(kind), "size": [shape.radius, 0.5 * shape.length, 0.0]}
    raise InputError(
        f"{type(shape).__name__}: MuJoCo has no such geom; expected Plane, Box, Sphere, Capsule, "
        "Cylinder or Mesh"
    )
