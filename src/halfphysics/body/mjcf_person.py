"""The MuJoCo model of a person's rigid parts: in an `MjSpec`, or as text.

A body's frame is its joint's frame; a ball joint at zero rotation is the rest pose.
"""

from __future__ import annotations

import colorsys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import (
    JOINT_NAMES,
    LEFT_HAND_JOINTS,
    N_JOINTS,
    PARENTS,
    RIGHT_HAND_JOINTS,
)

if TYPE_CHECKING:
    from xml.etree import ElementTree

    from halfphysics.body.rigid_parts import Part, Variant

Array = NDArray[np.float64]

#: Armature of finger joints [kg m^2] at stiffness 1. Finger tips weigh 3 to 7 g: without armature
#: they collapse in a grasp, with ten times as much they squeeze too hard.
FINGER_ARMATURE = 1e-3 / (1.0 + 1.0)
#: Root orientation (wxyz) of an upright person in the z-up world.
UPRIGHT = (float(np.sqrt(0.5)), float(np.sqrt(0.5)), 0.0, 0.0)


def add_person(
    spec: Any,
    variant: Variant,
    prefix: str = "",
    *,
    finger_armature: float = FINGER_ARMATURE,
    armature: ArrayLike | None = None,
    position: ArrayLike | None = None,
    quaternion: ArrayLike = UPRIGHT,
    geoms: bool = True,
    contype: int = 1,
    conaffinity: int = 0,
) -> Any:
    """Add the parts to a `mujoco.MjSpec` as a tree with a free root and 54 ball joints.

    Bodies, joints, meshes and geoms are all named prefix + joint name. MuJoCo numbers bodies depth
    first, so their ids are not in the order of `JOINT_NAMES`: see `addresses`. The free joint's
    coordinates are the pelvis joint's position in the world and the root orientation.

    Args:
        spec: The `mujoco.MjSpec` to add to.
        variant: The parts.
        prefix: Put before every name; needed for a second person.
        finger_armature: Armature of the 30 finger joints [kg m^2]; others have none.
        armature: Armature of all joints (55,) [kg m^2] instead; row 0 (the root) must be 0.
        position: Pelvis position at `qpos0` (3,) [m]; None stands the rest pose on z = 0.
        quaternion: Root orientation at `qpos0` (4,), wxyz; upright by default.
        geoms: Whether parts get geoms (for collision and drawing).
        contype, conaffinity: Of the geoms. By default the parts collide with MuJoCo's default
            geoms and not with each other: neighbours overlap.

    Returns:
        The pelvis body (`mujoco.MjsBody`).

    Raises:
        InputError: a bad armature, position or quaternion.
    """
    import mujoco

    inertia = _armature(finger_armature, armature)
    start, turn = _start(variant, position, quaternion)
    bodies: list[Any] = []
    for part in variant.parts:
        i, name = part.index, prefix + part.name
        if i == 0:
            body = spec.worldbody.add_body(name=name, pos=start, quat=turn)
            body.add_freejoint(name=name)
        else:
            body = bodies[PARENTS[i]].add_body(name=name, pos=variant.joint_offsets[i])
            body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_BALL, armature=inertia[i])
        body.mass = part.mass
        body.ipos = part.com
        body.inertia, body.iquat = principal(part.inertia)
        body.explicitinertial = True
        if geoms:
            _add_geom(spec, body, part, name, contype, conaffinity)
        bodies.append(body)
    return bodies[0]


def add_person_mocap(
    spec: Any, variant: Variant, prefix: str = "", *, contype: int = 1, conaffinity: int = 0
) -> None:
    """Add the parts to a `mujoco.MjSpec` as mocap bodies, whose poses are set from outside.

    Arguments and names as in `add_person`. Frames are the joints', all in the world.
    """
    for part in variant.parts:
        body = spec.worldbody.add_body(name=prefix + part.name, mocap=True)
        _add_geom(spec, body, part, prefix + part.name, contype, conaffinity)


def _add_geom(spec: Any, body: Any, part: Part, name: str, contype: int, conaffinity: int) -> None:
    """Add the hull of a part, if it has one."""
    import mujoco

    if not len(part.vertices):
        return
    # The spec may be somebody's whose default class scales or moves meshes and geoms.
    spec.add_mesh(
        name=name,
        uservert=part.vertices.ravel(),
        scale=np.ones(3),
        maxhullvert=-1,
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
    )
    geom = body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        pos=np.zeros(3),
        quat=(1.0, 0.0, 0.0, 0.0),
        rgba=part_color(part.index),
        contype=contype,
        conaffinity=conaffinity,
    )
    geom.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def to_mjcf(
    variant: Variant,
    *,
    finger_armature: float = FINGER_ARMATURE,
    armature: ArrayLike | None = None,
    model: str = "variant",
) -> str:
    """MJCF of the parts alone, self-contained: any MuJoCo opens it. Arguments as `add_person`."""
    from xml.etree import ElementTree

    root = ElementTree.Element("mujoco", model=model)
    default = ElementTree.SubElement(root, "default")
    add_defaults(default)
    assets = ElementTree.SubElement(root, "asset")
    world = ElementTree.SubElement(root, "worldbody")
    add_person_elements(assets, world, variant, finger_armature=finger_armature, armature=armature)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def add_defaults(default: ElementTree.Element) -> None:
    """The `<default>` settings of bodies and meshes that `add_person_elements` relies on."""
    from xml.etree import ElementTree

    ElementTree.SubElement(default, "mesh", inertia="convex")
    ElementTree.SubElement(default, "geom", type="mesh", contype="1", conaffinity="0")


def add_person_elements(
    assets: ElementTree.Element,
    world: ElementTree.Element,
    variant: Variant,
    prefix: str = "",
    *,
    finger_armature: float = FINGER_ARMATURE,
    armature: ArrayLike | None = None,
    childclass: str | None = None,
) -> None:
    """`add_person` for MJCF as text: into its `<asset>` and `<worldbody>`.

    Args:
        childclass: The default class that `add_defaults` filled; None: the one of the whole model.
    """
    from xml.etree import ElementTree

    inertia = _armature(finger_armature, armature)
    start, turn = _start(variant, None, UPRIGHT)
    of_body = {} if childclass is None else {"childclass": childclass}
    of_mesh = {} if childclass is None else {"class": childclass}
    bodies: list[ElementTree.Element] = []
    for part in variant.parts:
        i, name = part.index, prefix + part.name
        if i == 0:
            body = ElementTree.SubElement(
                world, "body", of_body, name=name, pos=text(start), quat=text(turn)
            )
            ElementTree.SubElement(body, "freejoint", name=name)
        else:
            parent, offset = bodies[PARENTS[i]], text(variant.joint_offsets[i])
            body = ElementTree.SubElement(parent, "body", name=name, pos=offset)
            ElementTree.SubElement(
                body, "joint", name=name, type="ball", armature=text([inertia[i]])
            )
        moments, axes = principal(part.inertia)
        ElementTree.SubElement(
            body,
            "inertial",
            pos=text(part.com),
            quat=text(axes),
            mass=text([part.mass]),
            diaginertia=text(moments),
        )
        if len(part.vertices):
            vertices = text(part.vertices.ravel())
            ElementTree.SubElement(assets, "mesh", of_mesh, name=name, vertex=vertices)
            rgba = text(np.round(part_color(i), 3))
            ElementTree.SubElement(body, "geom", name=name, mesh=name, rgba=rgba)
        bodies.append(body)


@dataclass(frozen=True, kw_only=True, eq=False)
class Addresses:
    """Addresses of a person's joints in a compiled `mujoco.MjModel`, in the order of `JOINT_NAMES`.

    Attributes:
        body: Body ids (55,).
        quat: First index of each joint's quaternion in qpos (55,), the root's included.
        dof: First index of each joint's three angular velocities in qvel (55,), also of the root.
        root_position, root_velocity: First indices of the pelvis position and linear velocity.
    """

    body: NDArray[np.int64]
    quat: NDArray[np.int64]
    dof: NDArray[np.int64]
    root_position: int
    root_velocity: int

    def write(self, qpos: Array, position: ArrayLike, quaternions: ArrayLike) -> None:
        """Put a pelvis position (3,) [m] and joint quaternions (55, 4) into qpos (nq,)."""
        qpos[self.root_position : self.root_position + 3] = position
        qpos[self.quat[:, None] + np.arange(4)] = quaternions


def addresses(model: Any, prefix: str = "") -> Addresses:
    """Addresses of a person in a `mujoco.MjModel` that `add_person` or `to_mjcf` made.

    Raises:
        InputError: the model has no person of that prefix.
    """
    try:
        body = np.array([model.body(prefix + name).id for name in JOINT_NAMES], dtype=np.int64)
        joint = [model.joint(prefix + name).id for name in JOINT_NAMES]
    except KeyError as error:
        raise InputError(
            f"variant: the model has no person with prefix {prefix!r}; was it added by add_person "
            "with that prefix?"
        ) from error
    quat = np.asarray(model.jnt_qposadr[joint], dtype=np.int64)
    dof = np.asarray(model.jnt_dofadr[joint], dtype=np.int64)
    position, velocity = int(quat[0]), int(dof[0])
    shift = np.zeros(N_JOINTS, dtype=np.int64)
    shift[0] = 3
    return Addresses(
        body=body,
        quat=quat + shift,
        dof=dof + shift,
        root_position=position,
        root_velocity=velocity,
    )


def part_color(index: int) -> tuple[float, float, float, float]:
    """Colour (rgba in 0..1) of a part, clearly different from those of adjacent parts."""
    hue = (index * 0.618033988749895) % 1.0
    return (*colorsys.hsv_to_rgb(hue, 0.55, 0.9), 1.0)


def _armature(finger_armature: float, armature: ArrayLike | None) -> Array:
    if armature is None:
        values = np.zeros(N_JOINTS)
        values[list(LEFT_HAND_JOINTS + RIGHT_HAND_JOINTS)] = finger_armature
    else:
        values = np.asarray(armature, dtype=np.float64)
    if values.shape != (N_JOINTS,):
        raise InputError(f"variant: armature has shape {values.shape}, expected ({N_JOINTS},)")
    if not np.isfinite(values).all() or (values < 0.0).any():
        raise InputError("variant: armature must be finite and not negative")
    if values[0] != 0.0:
        raise InputError(
            f"variant: armature of the pelvis is {values[0]}, expected 0: its joint is free, and "
            "MuJoCo would add one number to a mass and to an inertia"
        )
    return values


def _start(
    variant: Variant, position: ArrayLike | None, quaternion: ArrayLike
) -> tuple[Array, Array]:
    if position is None:
        position = (0.0, 0.0, variant.standing_height)
    start = np.asarray(position, dtype=np.float64)
    turn = np.asarray(quaternion, dtype=np.float64)
    if start.shape != (3,) or turn.shape != (4,):
        raise InputError(
            f"variant: position and quaternion have shapes {start.shape} and {turn.shape}, "
            "expected (3,) and (4,)"
        )
    if not np.isfinite(start).all() or not 1e-6 < np.linalg.norm(turn) < np.inf:
        raise InputError("variant: position must be finite and quaternion not zero")
    return start, turn


def principal(inertia: Array) -> tuple[Array, Array]:
    """Principal moments (3,) [kg m^2], rising, and the quaternion (4,) of their axes.

    Computed here because MuJoCo's own iteration stops at 1e-12, an error visible on finger tips.
    """
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return moments, rotations.from_matrix(axes)


def text(values: ArrayLike) -> str:
    """Numbers as an MJCF attribute that reads back bit for bit."""
    return " ".join(_digits(np.asarray(values, dtype=np.float64)))


def _digits(values: Array) -> Iterator[str]:
    return (repr(value) for value in values.tolist())
