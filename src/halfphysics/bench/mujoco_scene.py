"""A scene as MuJoCo geoms, for the peer: primitives as they are, meshes as convex pieces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.errors import InputError
from halfphysics.person_model import principal
from halfphysics.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere

if TYPE_CHECKING:
    from halfphysics.scene import Scene
    from halfphysics.shapes import Shape

Array = NDArray[np.float64]


def add_scene(spec: Any, scene: Scene, hulls: Mapping[str, Sequence[Array]]) -> None:
    """Add a scene to a `mujoco.MjSpec` that has its person already.

    A geom has the friction that its thing has with the person, by priority: by itself MuJoCo
    would take the larger of the two.

    Args:
        spec: The `mujoco.MjSpec`.
        scene: Statics and objects.
        hulls: Name of a static mesh -> points (n, 3) of its convex pieces [m], in its own frame.
    """
    for static in scene.statics.values():
        material = _material(scene, static.name)
        pose = {"pos": static.position, "quat": static.quaternion}
        if isinstance(static.shape, Mesh):
            for i, points in enumerate(hulls[static.name]):
                name = f"{static.name}/{i}"
                _add_mesh(spec, name, points)
                spec.worldbody.add_geom(type=_type("MESH"), meshname=name, **pose, **material)
        else:
            if isinstance(static.shape, Plane):
                pose = _plane_pose(static.shape, static.position, static.quaternion)
            spec.worldbody.add_geom(**_geom(static.shape), **pose, **material)
    for thing in scene.objects.values():
        body = spec.worldbody.add_body(
            name=f"object/{thing.name}", pos=thing.position, quat=thing.quaternion
        )
        body.add_freejoint()
        body.mass, body.ipos = thing.mass, thing.com
        body.inertia, body.iquat = principal(thing.inertia)
        body.explicitinertial = True
        body.add_geom(**_geom(thing.shape), **_material(scene, thing.name))


def _type(name: str) -> Any:
    import mujoco

    return getattr(mujoco.mjtGeom, f"mjGEOM_{name}")


def _add_mesh(spec: Any, name: str, points: Array) -> None:
    import mujoco

    spec.add_mesh(
        name=name,
        uservert=np.ravel(points),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
    )


def _material(scene: Scene, name: str) -> dict[str, Any]:
    return {"friction": [scene.friction_of("person", name), 0.005, 0.0001], "priority": 1}


def _plane_pose(plane: Plane, position: Array, quaternion: Array) -> dict[str, Any]:
    """Place of MuJoCo's plane, which is z = 0 of its own frame."""
    normal = rot.rotate(quaternion, np.asarray(plane.normal, dtype=np.float64))
    axis = np.array([-normal[1], normal[0], 0.0])  # z cross normal
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    turn = rot.exp(np.arctan2(sine, normal[2]) * axis)
    return {"pos": position + plane.offset * normal, "quat": turn}


def _geom(shape: Shape) -> dict[str, Any]:
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
    raise InputError(f"{type(shape).__name__}: the peer takes primitives and static meshes only")
