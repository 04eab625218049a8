"""Contact geometry of the geoms of a compiled MuJoCo model."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.colliders import ConvexCollider, convex_collider, hull_collider

Array = NDArray[np.float64]


def collides(model: Any, geom: int) -> bool:
    """Whether a geom can collide, by its `contype` and `conaffinity`."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


def geom_name(model: Any, geom: int) -> str:
    """The geom's name; if it has none, its body's name and the geom's number."""
    named = model.geom(geom).name
    return named or f"{model.body(model.geom_bodyid[geom]).name}/geom{geom}"


def geom_kind(model: Any, geom: int) -> str:
    """MuJoCo's name of a geom's type: "plane", "box", "mesh", ..."""
    import mujoco

    return str(mujoco.mjtGeom(int(model.geom_type[geom])).name).removeprefix("mjGEOM_").lower()


def geom_collider(model: Any, geom: int) -> ConvexCollider:
    """Collider of a convex geom in its own frame (for a mesh: its convex hull, as in MuJoCo).

    Raises:
        InputError: A plane, a height field or a signed distance field.
    """
    from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Sphere

    kind, size = geom_kind(model, geom), np.array(model.geom_size[geom], dtype=np.float64)
    if kind == "sphere":
        return convex_collider(Sphere(size[0]))
    if kind == "capsule":
        return convex_collider(Capsule(size[0], 2.0 * size[1]))
    if kind == "cylinder":
        return convex_collider(Cylinder(size[0], 2.0 * size[1]))
    if kind == "box":
        return convex_collider(Box(tuple(2.0 * size)))
    if kind == "ellipsoid":
        return hull_collider(_ball() * size)
    if kind == "mesh":
        return hull_collider(mesh_triangles(model, geom)[0])
    if kind == "sdf":
        raise InputError(
            f"geom '{geom_name(model, geom)}': a signed distance field (sdf) cannot be touched; "
            "expected sphere, capsule, ellipsoid, cylinder, box or mesh. Make it a mesh, or set "
            "contype and conaffinity to 0"
        )
    raise InputError(
        f"geom '{geom_name(model, geom)}': a {kind} that moves cannot be touched; expected sphere, "
        "capsule, ellipsoid, cylinder, box or mesh. Fix it to the world, or set contype and "
        "conaffinity to 0"
    )


def mesh_triangles(model: Any, geom: int) -> tuple[Array, NDArray[np.int32]]:
    """Vertices (V, 3) [m] and faces (F, 3) of a mesh or height field, in the geom's frame."""
    data = int(model.geom_dataid[geom])
    if geom_kind(model, geom) == "hfield":
        return _height_field(model, data)
    first, count = int(model.mesh_vertadr[data]), int(model.mesh_vertnum[data])
    vertices = np.array(model.mesh_vert[first : first + count], dtype=np.float64)
    first, count = int(model.mesh_faceadr[data]), int(model.mesh_facenum[data])
    return vertices, np.array(model.mesh_face[first : first + count], dtype=np.int32)


def fixed_poses(model: Any) -> tuple[Array, Array]:
    """Rotations (n, 3, 3) and positions (n, 3) of all geoms at `qpos0`; valid for static geoms."""
    import mujoco

    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return np.array(data.geom_xmat).reshape(-1, 3, 3), np.array(data.geom_xpos)


def pose_in_body(model: Any, geom: int) -> tuple[Array, Array]:
    """Rotation (3, 3) and position (3,) of a geom in its body's frame."""
    return rot.to_matrix(np.array(model.geom_quat[geom])), np.array(model.geom_pos[geom])


def _height_field(model: Any, data: int) -> tuple[Array, NDArray[np.int32]]:
    rows, columns = int(model.hfield_nrow[data]), int(model.hfield_ncol[data])
    first = int(model.hfield_adr[data])
    half_x, half_y, top, _ = model.hfield_size[data]
    heights = np.array(model.hfield_data[first : first + rows * columns], dtype=np.float64)
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    vertices = np.stack([x.ravel(), y.ravel(), top * heights], axis=-1)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    # MuJoCo cuts every cell from its lowest to its highest row and column.
    across = corner + columns + 1
    low = np.stack([corner, corner + 1, across], axis=-1)
    high = np.stack([corner, across, corner + columns], axis=-1)
    return vertices, np.concatenate([low, high]).astype(np.int32)


def _ball() -> Array:
    """Points on the unit sphere, dense enough that their hull is within 1 % of it."""
    count = 400
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1)
