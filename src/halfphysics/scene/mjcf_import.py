"""Articulated objects from MJCF or URDF: MuJoCo compiles them, links and joints are copied."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base.validation import file_bytes, file_path, number, quaternion, shown, vector
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.mesh import Mesh, MeshSource
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Sphere
from halfphysics.scene.articulated import SIZES, Articulated, Link, LinkGeom, LinkJoint
from halfphysics.scene.mjcf_process import CompiledModel, compiled, of_spec
from halfphysics.scene.mjcf_text import (
    SOURCES,
    asset_bytes,
    check_files,
    checked_xml,
    files_of,
    named_files,
)
from halfphysics.scene.package_paths import package_files

#: Name of the link for geoms that belong to no body.
WORLD = "world"
_KINDS = ("free", "ball", "slide", "hinge")
_ELLIPSOID_POINTS = 300
#: Bytes of the file of an object.
_MOST_BYTES = 2**26
#: Gravity of files that say none [m/s^2]; what is about the same is meant to be the same.
_GRAVITY, _ABOUT = (0.0, 0.0, -9.81), 0.02
#: What may stand before the first element of a text: spaces, and the mark of its encoding.
_BEFORE = " \t\r\n\ufeff"


def load_articulated(
    name: str,
    source: Any,
    *,
    joints: Mapping[str, Any] | None,
    velocities: Mapping[str, Any] | None,
    **place: Any,
) -> Articulated:
    """The work behind `Scene.add_articulated`; see there."""
    what = f"articulated {name!r}"
    model, origin = _model(what, source)
    links = _links(what, model)
    named = {j.name: j for link in links for j in link.joints}
    if not any(joint.kind != "free" for joint in named.values()):
        raise InputError(
            f"{what}: found no joints, expected at least one hinge, slide or ball joint; "
            "add_object and add_static take what is rigid"
        )
    _warn_of_ignored(what, model)
    return Articulated(
        name=name,
        links=links,
        joints=_starts(what, named, joints),
        velocities=_speeds(what, named, velocities),
        **place,
        **origin,
    )


def _model(what: str, source: Any) -> tuple[CompiledModel, dict[str, Any]]:
    """The compiled model, and its source."""
    import mujoco

    if isinstance(source, mujoco.MjSpec):
        return _of_spec(what, source.copy())
    try:
        text = source.decode() if isinstance(source, bytes) else source
    except UnicodeDecodeError:
        raise InputError(f"{what}: found bytes that are no text, expected {SOURCES}") from None
    if isinstance(text, str) and text.lstrip(_BEFORE).startswith("<"):
        text = text.lstrip(_BEFORE)
        root = checked_xml(what, text, None)
        if root.tag == "robot":
            package_files(what, root, None)
        model = compiled(
            what,
            {"xml": text, "urdf": root.tag == "robot"},
            reads_files=bool(named_files(root, Path())),
        )
        return model, {"xml": text}
    if not isinstance(text, str | os.PathLike):
        raise InputError(f"{what}: found {shown(source)} as source, expected {SOURCES}")
    path = file_path(text)
    if not path.is_file():
        raise FileError(f"{what}: {shown(str(path))}: there is no such file, expected {SOURCES}")
    if path.stat().st_size > _MOST_BYTES:
        raise FileError(
            f"{what}: {path}: {path.stat().st_size / 2**20:.0f} MiB, expected at most "
            f"{_MOST_BYTES / 2**20:.0f} MiB of MJCF or URDF"
        )
    content = file_bytes(path)
    try:
        root = checked_xml(what, content.decode(), path)
    except UnicodeDecodeError:
        raise FileError(f"{what}: {path}: found no text, expected {SOURCES}") from None
    folder, urdf = path.resolve().parent, root.tag == "robot"
    packed = package_files(what, root, folder) if urdf else {}
    check_files(f"{what}: {path}", [Path(p) for p in packed.values()])
    model = compiled(
        what,
        {"path": str(path), "urdf": urdf, "files": dict(packed)},
        assets=asset_bytes([*named_files(root, folder), *map(Path, packed.values())]),
    )
    digest = hashlib.sha256(content).hexdigest()
    return model, {"source": MeshSource(path=str(path.resolve()), sha256=digest)}


def _of_spec(what: str, spec: Any) -> tuple[CompiledModel, dict[str, Any]]:
    """Of a model that the caller made in this process.

    The model is that of its text, which is what is saved and has six digits; unless files that it
    names are in memory alone. The folders of the others are absolute there.
    """
    import mujoco

    try:
        whole, text = of_spec(spec), spec.to_xml()
        if any(files_of(ElementTree.fromstring(text))):
            for key in ("meshdir", "texturedir"):
                setattr(spec, key, str((Path(spec.modelfiledir) / getattr(spec, key)).resolve()))
            text = spec.to_xml()
        if not spec.assets:
            whole = of_spec(mujoco.MjSpec.from_string(text))
        return whole, {"xml": text}
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"{what}: MuJoCo cannot compile it: {reason}. Expected a model that MuJoCo itself "
            "loads, with its mesh files in their place and masses of all that moves"
        ) from None


def _links(what: str, model: Any) -> tuple[Link, ...]:
    geoms: dict[int, list[LinkGeom]] = {}
    for g in range(model.ngeom):
        if model.geom_contype[g] or model.geom_conaffinity[g]:
            geoms.setdefault(int(model.geom_bodyid[g]), []).append(_geom(what, model, g))
    links: list[Link] = []
    index: dict[int, int] = {}
    taken: set[str] = set()
    for b in range(model.nbody):
        mine = tuple(geoms.get(b, ()))
        if b == 0 and not mine:
            continue
        base = (WORLD if b == 0 else model.bodies[b]) or f"link{b}"
        link = _unique(base, taken)
        joints = tuple(
            _joint(what, model, j, link)
            for j in range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b])
        )
        parent = index.get(int(model.body_parentid[b]), -1) if b else -1
        # Geoms of MuJoCo's world body are placed in the articulated object's frame.
        if b and model.body_parentid[b] == 0:
            parent = -1
        fixed = not joints and (parent < 0 or links[parent].fixed)
        index[b] = len(links)
        links.append(
            Link(
                name=link,
                parent=parent,
                position=_fixed(model.body_pos[b]),
                quaternion=_fixed(model.body_quat[b]),
                mass=float(model.body_mass[b]),
                com=_fixed(model.body_ipos[b]),
                inertia=_fixed(model.body_inertia[b]),
                inertia_quaternion=_fixed(model.body_iquat[b]),
                joints=joints,
                geoms=mine,
                fixed=fixed,
            )
        )
    joints_of = [j.name for link in links for j in link.joints]
    if len(set(joints_of)) < len(joints_of):
        raise InputError(
            f"{what}: two joints have one name among {', '.join(joints_of)}; name them"
        )
    return tuple(links)


def _unique(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _joint(what: str, model: Any, j: int, link: str) -> LinkJoint:
    kind = _KINDS[int(model.jnt_type[j])]
    body = int(model.jnt_bodyid[j])
    only = int(model.body_jntnum[body]) == 1
    name = model.joints[j] or (link if only else f"{link}_{j - model.body_jntadr[body]}")
    limited = bool(model.jnt_limited[j])
    if limited and kind not in ("hinge", "slide"):
        raise InputError(
            f"{what}: joint {name!r} is a {kind} joint with a range, expected hinges or slides "
            "with ranges; remove the range, or make it of hinges"
        )
    at, dof = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
    scalar = kind in ("hinge", "slide")
    return LinkJoint(
        name=name,
        kind=kind,
        position=_fixed(model.jnt_pos[j]),
        axis=_fixed(model.jnt_axis[j]),
        reference=float(model.qpos0[at]) if scalar else 0.0,
        lower=float(model.jnt_range[j, 0]) if limited else -np.inf,
        upper=float(model.jnt_range[j, 1]) if limited else np.inf,
        damping=float(model.dof_damping[dof]),
        stiffness=float(model.jnt_stiffness[j]),
        springref=float(model.qpos_spring[at]) if scalar else 0.0,
        armature=float(model.dof_armature[dof]),
    )


def _geom(what: str, model: Any, g: int) -> LinkGeom:
    import mujoco

    kinds = mujoco.mjtGeom
    kind, size = kinds(int(model.geom_type[g])), [float(s) for s in model.geom_size[g]]
    shape: Shape
    if kind == kinds.mjGEOM_BOX:
        shape = Box([2 * s for s in size])
    elif kind == kinds.mjGEOM_SPHERE:
        shape = Sphere(size[0])
    elif kind == kinds.mjGEOM_CAPSULE:
        shape = Capsule(size[0], 2 * size[1])
    elif kind == kinds.mjGEOM_CYLINDER:
        shape = Cylinder(size[0], 2 * size[1])
    elif kind == kinds.mjGEOM_ELLIPSOID:
        shape = _hull(_sphere_points() * np.array(size))
    elif kind == kinds.mjGEOM_MESH:
        data = int(model.geom_dataid[g])
        first, count = model.mesh_vertadr[data], model.mesh_vertnum[data]
        shape = _hull(np.array(model.mesh_vert[first : first + count], dtype=np.float64))
    else:
        found = kind.name.removeprefix("mjGEOM_").lower()
        raise InputError(
            f"{what}: found a {found} in {model.bodies[int(model.geom_bodyid[g])] or WORLD!r}, "
            "expected boxes, spheres, capsules, cylinders, ellipsoids and meshes. Add planes with "
            'add_static(name, Plane()); contype="0" conaffinity="0" keeps a geom for looks alone'
        )
    return LinkGeom(
        shape=shape,
        position=_fixed(model.geom_pos[g]),
        quaternion=_fixed(rot.normalize(model.geom_quat[g])),
    )


def _hull(points: Any) -> Mesh:
    from scipy.spatial import ConvexHull, QhullError

    try:
        faces = ConvexHull(points).simplices
    except QhullError:
        raise InputError("a mesh of an articulated object is flat, expected a solid") from None
    return Mesh(points, faces).hull


def _sphere_points() -> Any:
    """Points spread evenly over the unit sphere (n, 3)."""
    i = np.arange(_ELLIPSOID_POINTS) + 0.5
    z, turn = 1.0 - 2.0 * i / _ELLIPSOID_POINTS, np.pi * (1.0 + np.sqrt(5.0)) * i
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def _warn_of_ignored(what: str, model: Any) -> None:
    """One warning for each kind of element that is ignored."""
    counts = {
        "actuators": model.nu,
        "tendons": model.ntendon,
        "equality constraints (in URDF: mimic joints)": model.neq,
        "flexible bodies": model.nflex,
        "mocap bodies, which stand still here,": model.nmocap,
        "keyframes": model.nkey,
        "friction losses of joints": int(np.count_nonzero(model.dof_frictionloss)),
        "gravity compensations": int(np.count_nonzero(model.body_gravcomp)),
        # Older versions of MuJoCo do not have this list.
        "damping and stiffness that are not linear": sum(
            int(np.count_nonzero(getattr(model, field, ())))
            for field in ("dof_dampingpoly", "jnt_stiffnesspoly")
        ),
    }
    for kind, count in counts.items():
        if count:
            warnings.warn(
                f"{what}: {count} {kind} ignored; joints, ranges, damping and springs are kept",
                HalfPhysicsWarning,
                stacklevel=4,
            )
    if np.linalg.norm(np.subtract(model.gravity, _GRAVITY)) > _ABOUT:
        warnings.warn(
            f"{what}: gravity {tuple(model.gravity)} m/s^2 ignored; it falls with the scene's, "
            "Scene(gravity=...)",
            HalfPhysicsWarning,
            stacklevel=4,
        )


def _known(what: str, key: str, named: Mapping[str, LinkJoint], given: Any) -> dict[str, Any]:
    given = {} if given is None else given
    if not isinstance(given, Mapping):
        raise InputError(f"{what}: {key}: found {shown(given)}, expected joint names and values")
    for name in given:
        if name not in named or named[name].kind == "free":
            known = ", ".join(n for n, j in named.items() if j.kind != "free")
            raise InputError(
                f"{what}: {key}: found no joint {shown(name)}; it has: {known or 'none'}"
            )
    return dict(given)


def _starts(what: str, named: Mapping[str, LinkJoint], given: Any) -> dict[str, Any]:
    values = _known(what, "joints", named, given)
    for name, joint in named.items():
        if joint.kind in ("free", "ball"):
            if name in values:
                values[name] = quaternion(values[name], f"{what}: joints[{name!r}]").tolist()
            continue
        at = joint.reference
        if name in values:
            at = values[name] = number(values[name], f"{what}: joints[{name!r}]")
        if not joint.lower <= at <= joint.upper:
            raise InputError(
                f"{what}: joint {name!r} starts at {at:g}, expected {joint.lower:g} to "
                f"{joint.upper:g}; say where with joints={{{name!r}: ...}}"
            )
    return values


def _speeds(what: str, named: Mapping[str, LinkJoint], given: Any) -> dict[str, Any]:
    speeds = _known(what, "velocities", named, given)
    for name, value in speeds.items():
        label = f"{what}: velocities[{name!r}]"
        if SIZES[named[name].kind][1] == 1:
            speeds[name] = number(value, label)
        else:
            speeds[name] = vector(value, label).tolist()
    return speeds


def _fixed(values: Any) -> Any:
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
