"""The objects of ARCTIC: two parts, `top` on `bottom`, with a hinge along the z axis of both.

A clip has `(T, 7)` numbers: the angle of the hinge [rad], the rotation (axis-angle) and the
translation [mm] of the bottom. The top rotates about -z by the angle, then both are rotated
and translated: vertices of the bottom are ``R v + t``, of the top ``R exp(-angle z) v + t``,
meshes in mm.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.formats.datasets.recorded import DENSITY, add_recorded, assumed_mass
from halfphysics.formats.format import Options
from halfphysics.geometry.contact_pieces import asked, touching
from halfphysics.geometry.convex_decomposition import THRESHOLD
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_files import load_mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.results.result import ObjectTrack

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

PARTS = ("bottom", "top")
MILLIMETRE = 1e-3
HINGE = "hinge"
_AXIS = np.array([0.0, 0.0, -1.0])
# Damping of a stiff lid [N m s]: an assumption, the data set has no value.
_DAMPING = 0.01
# Smallest range of a hinge, for clips that hardly open it [rad].
_LEAST_RANGE = 0.1
#: A hinge that turns by less than this in the whole clip does not move [rad].
STILL = 0.01


def add_hinged(
    scene: Scene,
    name: str,
    meshes: Mapping[str, Path],
    pose: Array,
    *,
    where: str,
    axes: Array,
    fps: float,
    options: Options,
) -> dict[str, ObjectTrack]:
    """Add the object of a clip: an articulated one, or two replayed parts (`Options.objects`).

    A free object whose hinge does not move in the clip is one rigid object, ``name``. Any other
    free one is ``name`` with links "name/bottom" and "name/top" and the joint "name/hinge", whose
    range is that of the clip. A replayed object is "name_bottom" and "name_top".

    Args:
        scene: Scene to add it to.
        name: Name of the object.
        meshes: Mesh file of each of `PARTS`, in mm.
        pose: Poses (T, 7) of the data set, file axes.
        where: Name of the clip in messages.
        axes: World from file axes (3, 3), as `Motion.axes`.
        fps: Frame rate of the poses.
        options: Options of the caller.

    Returns:
        The recorded poses of the parts in the world, by name in the scene.

    Raises:
        FileError, InputError: A mesh cannot be used.
    """
    angles = pose[:, 0]
    places = (options.unit * MILLIMETRE * pose[:, 4:]) @ axes.T
    turns = rot.multiply(rot.from_matrix(axes), rot.exp(pose[:, 1:4]))
    opened = rot.normalize(rot.multiply(turns, rot.exp(angles[:, None] * _AXIS)))
    poses = {"bottom": rot.normalize(turns), "top": opened}
    joined = "_" if options.objects == "replayed" else "/"
    tracks = {
        f"{name}{joined}{part}": ObjectTrack(position=places, quaternion=poses[part])
        for part in PARTS
    }
    if options.objects == "replayed":
        for part in PARTS:
            scene.add_moving(
                f"{name}_{part}",
                meshes[part],
                places,
                poses[part],
                fps=fps,
                scale=MILLIMETRE,
                up="z",
            )
        return tracks
    solids = {part: load_mesh(meshes[part], scale=MILLIMETRE, up="z")[0] for part in PARTS}
    if np.ptp(angles) < STILL:
        solid, pieces = _rigid(f"{where}: object {name!r}", solids, float(np.median(angles)))
        warn(f"{where}: the hinge of {name!r} does not move: both parts are one rigid object")
        turned = rot.rotvec_to_matrix(pose[:, 1:4])
        return {
            name: add_recorded(
                scene, name, solid, MILLIMETRE * pose[:, 4:], turned,
                where=where, axes=axes, fps=fps, options=options, pieces=pieces,
            )
        }  # fmt: skip
    spec, masses = _hinged(f"{where}: object {name!r}", solids, angles)
    warn(
        f"{where}: nothing says what {name!r} weighs, how its hinge rubs or what it stands on: "
        f"{masses['bottom']:.3g} kg and {masses['top']:.3g} kg are taken, {DENSITY:g} kg/m^3 or "
        f"less if it is large, and {_DAMPING:g} N m s. Add what it stands on with "
        "scene.add_static, or say objects='replayed'"
    )
    scene.add_articulated(
        name,
        spec,
        position=places[0],
        quaternion=poses["bottom"][0],
        joints={HINGE: float(angles[0])},
    )
    return tracks


def _pieces(what: str, solid: Mesh) -> tuple[Shape, list[Mesh]]:
    """The solid that a part collides with, and its convex pieces."""
    _, cut = asked(what, solid, "auto", THRESHOLD, None)
    touches, made = touching(what, solid, cut, None)
    return touches, [Mesh(*p.triangles()) for p in ((touches,) if made is None else made.pieces)]


def _rigid(what: str, solids: Mapping[str, Mesh], angle: float) -> tuple[Mesh, list[Mesh]]:
    """Both parts as one mesh in the bottom's frame, the top turned by `angle`, and its pieces."""
    turn = rot.rotvec_to_matrix(angle * _AXIS)
    vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)
    pieces: list[Mesh] = []
    for part in PARTS:
        own = turn if part == "top" else np.eye(3)
        faces = np.concatenate([faces, solids[part].faces + np.int32(len(vertices))])
        vertices = np.concatenate([vertices, solids[part].vertices @ own.T])
        _, cut = _pieces(f"{what}, {part}", solids[part])
        pieces += [Mesh(piece.vertices @ own.T, piece.faces) for piece in cut]
    return Mesh(vertices, faces), pieces


def _hinged(what: str, solids: Mapping[str, Mesh], angles: Array) -> tuple[Any, dict[str, float]]:
    """The MjSpec of both parts, and their masses [kg]."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    masses, made = {}, {part: _pieces(f"{what}, {part}", solids[part]) for part in PARTS}
    filled = {part: solids[part] if solids[part].closed else made[part][0] for part in PARTS}
    volume = sum(shape.volume for shape in filled.values())
    density = assumed_mass(volume) / volume
    parent = spec.worldbody
    for part in PARTS:
        body = parent.add_body(name=part)
        if part == "bottom":
            body.add_freejoint()
        else:
            hinge = body.add_joint(name=HINGE, type=mujoco.mjtJoint.mjJNT_HINGE, axis=_AXIS)
            hinge.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            hinge.range = _range(angles)
            # Later releases have one coefficient per power of the velocity: set the first.
            powers = np.ndim(hinge.damping) and len(hinge.damping)
            hinge.damping = [_DAMPING, *[0.0] * (powers - 1)] if powers else _DAMPING
        pieces = made[part][1]
        properties = filled[part].mass_properties(density=density)
        body.explicitinertial = True
        body.mass, body.ipos = properties.mass, properties.com
        i = properties.inertia
        body.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        for index, piece in enumerate(pieces):
            vertices, faces = piece.vertices, piece.faces
            mesh = spec.add_mesh(name=f"{part}{index}")
            mesh.uservert, mesh.userface = vertices.ravel(), faces.ravel()
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name)
        masses[part] = properties.mass
        parent = body
    return spec, masses


def _range(angles: Array) -> list[float]:
    """The range from shut to widest in the clip [rad], to three decimals: exact in text."""
    low = min(0.0, float(angles.min()))
    high = max(low + _LEAST_RANGE, float(angles.max()))
    return [float(np.floor(1e3 * low) / 1e3), float(np.ceil(1e3 * high) / 1e3)]
