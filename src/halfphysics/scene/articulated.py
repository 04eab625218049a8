"""Articulated objects: links that move about joints, such as doors, drawers, laptops and scissors.

World z-up, metres, radians, kilograms, seconds; quaternions wxyz. `mjcf_import` reads them from
MJCF and URDF files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.geometry.colliders import ConvexCollider, convex_collider
from halfphysics.geometry.shape_base import Shape, Triangles

if TYPE_CHECKING:
    from halfphysics.geometry.mesh import MeshSource

Array = NDArray[np.float64]

#: Coordinates and velocities of a joint of each kind.
SIZES = {"free": (7, 6), "ball": (4, 3), "slide": (1, 1), "hinge": (1, 1)}


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkGeom(ReadOnly):
    """A convex solid of a link that touches; pose of its frame in the link's."""

    shape: Shape
    position: Array
    quaternion: Array

    __repr__ = short_repr

    def collider(self) -> ConvexCollider:
        """The collision geometry, in the link's frame."""
        return convex_collider(self.shape).moved(rot.to_matrix(self.quaternion), self.position)


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkJoint(ReadOnly):
    """A joint between a link and its parent.

    `kind`: "hinge", "slide", "ball" or "free". `position` (3,) and unit `axis` (3,) in the link's
    frame, `reference` the coordinate at which link and parent are as given, `lower` and `upper`
    (infinite: no end) and `springref` of the same coordinate [rad or m], `damping`
    [N m s or N s/m], `stiffness` [N m or N/m], `armature` [kg m^2 or kg].
    """

    name: str
    kind: str
    position: Array
    axis: Array
    reference: float = 0.0
    lower: float = -np.inf
    upper: float = np.inf
    damping: float = 0.0
    stiffness: float = 0.0
    springref: float = 0.0
    armature: float = 0.0

    __repr__ = short_repr

    @property
    def limited(self) -> bool:
        return bool(np.isfinite(self.lower))


@dataclass(frozen=True, kw_only=True, eq=False)
class Link(ReadOnly):
    """A rigid body of an articulated object.

    `parent` is an index into the links (-1: the articulated object's own frame), `position` and
    `quaternion` the pose in it where joints are at their reference. `mass` [kg], `com` (3,) and
    principal moments `inertia` (3,) [kg m^2] along the axes of `inertia_quaternion`, in the link's
    frame. `fixed`: no joint moves it.
    """

    name: str
    parent: int
    position: Array
    quaternion: Array
    mass: float
    com: Array
    inertia: Array
    inertia_quaternion: Array
    joints: tuple[LinkJoint, ...]
    geoms: tuple[LinkGeom, ...]
    fixed: bool

    __repr__ = short_repr

    def mesh(self) -> Triangles:
        """Vertices (V, 3) [m] and faces (F, 3) of the collision geometry, in the link's frame."""
        vertices, faces = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int32)]
        count = 0
        for geom in self.geoms:
            v, f = geom.shape.triangles()
            vertices.append(rot.rotate(geom.quaternion, v) + geom.position)
            faces.append(np.asarray(f, dtype=np.int32) + count)
            count += len(v)
        return np.concatenate(vertices), np.concatenate(faces)


@dataclass(frozen=True, kw_only=True, eq=False)
class Articulated(ReadOnly):
    """Links and joints that move by contact and gravity; frame at `position`, `quaternion`.

    Results name its links "NAME/LINK" (`Result.objects`, `Result.names`) and its joints
    "NAME/JOINT" (`Result.joints`). Links of one articulated object do not touch each other.
    `joints` and `velocities`: start values of joints that do not start at their reference, at rest.
    `source`: the file, or `xml`: the text from which it was made; `given_mass`: the mass of what
    moves that was asked for [kg], None: as it stands there.
    """

    name: str
    links: tuple[Link, ...]
    position: Array
    quaternion: Array
    friction: float
    restitution: float
    joints: Mapping[str, Any]
    velocities: Mapping[str, Any]
    source: MeshSource | None = None
    xml: str | None = None
    given_mass: float | None = None

    @property
    def mass(self) -> float:
        """Mass of the links that move [kg]."""
        return float(sum(link.mass for link in self.links if not link.fixed))

    def weighing(self, mass: float | None) -> Articulated:
        """The same of another mass [kg]: masses and inertias of links that move are scaled evenly;
        None: itself."""
        if mass is None:
            return self
        factor = mass / self.mass
        links = tuple(
            link
            if link.fixed
            else replace(link, mass=link.mass * factor, inertia=link.inertia * factor)
            for link in self.links
        )
        return replace(self, links=links, given_mass=mass)

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links in results."""
        return tuple(f"{self.name}/{link.name}" for link in self.links)

    def __repr__(self) -> str:
        joints = [j.name for link in self.links for j in link.joints]
        return f"Articulated({self.name!r}, links={[n.name for n in self.links]}, joints={joints})"


@dataclass(frozen=True, eq=False)
class JointPlace:
    """Indices of a joint's values in the model's coordinates."""

    name: str
    joint: LinkJoint
    qpos: int
    dof: int

    def values(self, qpos: Array) -> Array:
        """Values at (..., nq): (...,) of a hinge or slide, (..., 4) of a ball, (..., 7) free."""
        size = SIZES[self.joint.kind][0]
        if size == 1:
            return np.array(qpos[..., self.qpos])
        return np.array(qpos[..., self.qpos : self.qpos + size])


@dataclass(frozen=True, eq=False)
class LinkPlace:
    """A link in a world: its pose follows from the coordinates of the joints before it."""

    name: str
    parent: LinkPlace | None
    position: Array  # in the parent; in the world without one
    quaternion: Array
    joints: tuple[JointPlace, ...]

    def pose(self, qpos: Array) -> tuple[Array, Array]:
        """Position (..., 3) and quaternion (..., 4) of the frame at coordinates (..., nq)."""
        lead = qpos.shape[:-1]
        position = np.broadcast_to(self.position, (*lead, 3))
        quat = np.broadcast_to(self.quaternion, (*lead, 4))
        if self.parent is not None:
            base, turn = self.parent.pose(qpos)
            position, quat = base + rot.rotate(turn, position), rot.multiply(turn, quat)
        for place in self.joints:
            joint, value = place.joint, place.values(qpos)
            if joint.kind == "free":
                return value[..., :3], rot.normalize(value[..., 3:])
            if joint.kind == "slide":
                way = (value - joint.reference)[..., None] * joint.axis
                position = position + rot.rotate(quat, way)
                continue
            anchor = position + rot.rotate(quat, np.broadcast_to(joint.position, (*lead, 3)))
            if joint.kind == "ball":
                quat = rot.multiply(quat, rot.normalize(value))
            else:
                turn = rot.exp((value - joint.reference)[..., None] * joint.axis)
                quat = rot.multiply(quat, turn)
            position = anchor - rot.rotate(quat, np.broadcast_to(joint.position, (*lead, 3)))
        return np.array(position), rot.normalize(quat)


def add_bodies(spec: Any, item: Articulated) -> None:
    """The links as bodies of an MjSpec, without geometry; names as `places` expects them."""
    import mujoco

    kinds = {
        "free": mujoco.mjtJoint.mjJNT_FREE,
        "ball": mujoco.mjtJoint.mjJNT_BALL,
        "slide": mujoco.mjtJoint.mjJNT_SLIDE,
        "hinge": mujoco.mjtJoint.mjJNT_HINGE,
    }
    bodies: list[Any] = []
    for i, link in enumerate(item.links):
        position, quat = placed(item, link)
        parent = spec.worldbody if link.parent < 0 else bodies[link.parent]
        b = parent.add_body(name=f"articulated/{item.name}/{i}", pos=position, quat=quat)
        bodies.append(b)
        b.mass, b.ipos, b.inertia = link.mass, link.com, link.inertia
        b.iquat, b.explicitinertial = link.inertia_quaternion, True
        for k, joint in enumerate(link.joints):
            j = b.add_joint(name=f"articulated/{item.name}/{i}/{k}", type=kinds[joint.kind])
            j.armature = joint.armature
            # MuJoCo has one number per power of the velocity (of the distance): the first.
            for field in ("damping", "stiffness"):
                value = getattr(joint, field)
                plain = np.ndim(getattr(j, field)) == 0
                setattr(
                    j, field, value if plain else [value, *[0.0] * (len(getattr(j, field)) - 1)]
                )
            if joint.kind == "free":
                continue
            j.pos = joint.position
            if joint.kind != "ball":
                j.axis, j.ref, j.springref = joint.axis, joint.reference, joint.springref
                j.limited = int(joint.limited)
                if joint.limited:
                    j.range = [joint.lower, joint.upper]
    # The numbers are in radians already.
    spec.compiler.degree = False


def places(model: Any, item: Articulated) -> tuple[tuple[LinkPlace, ...], tuple[JointPlace, ...]]:
    """The links and joints of an articulated object in a compiled model."""
    links: list[LinkPlace] = []
    joints: list[JointPlace] = []
    for i, link in enumerate(item.links):
        mine = []
        for k, joint in enumerate(link.joints):
            j = model.joint(f"articulated/{item.name}/{i}/{k}").id
            at = int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j])
            mine.append(JointPlace(f"{item.name}/{joint.name}", joint, *at))
        joints += mine
        parent = links[link.parent] if link.parent >= 0 else None
        name = f"{item.name}/{link.name}"
        links.append(LinkPlace(name, parent, *placed(item, link), tuple(mine)))
    return tuple(links), tuple(joints)


def start(model: Any, item: Articulated, qpos: Array, qvel: Array) -> None:
    """Write the start values of the joints into coordinates (nq,) and velocities (nv,)."""
    for link, place in zip(item.links, places(model, item)[0], strict=True):
        for at in place.joints:
            joint, (count, speeds) = at.joint, SIZES[at.joint.kind]
            qpos[at.qpos : at.qpos + count] = start_of(item, link, joint)
            qvel[at.dof : at.dof + speeds] = item.velocities.get(joint.name, 0.0)


def start_of(item: Articulated, link: Link, joint: LinkJoint) -> Any:
    """The start value of a joint: a number, or a quaternion or pose, depending on its kind."""
    value: Any = joint.reference
    if joint.kind == "free":
        value = np.concatenate(placed(item, link))
    elif joint.kind == "ball":
        value = [1.0, 0.0, 0.0, 0.0]
    return item.joints.get(joint.name, value)


def start_poses(item: Articulated) -> list[tuple[Array, Array]]:
    """Position (3,) [m] and quaternion (4,) in the world of every link at the start."""
    import mujoco

    spec = mujoco.MjSpec()
    add_bodies(spec, item)
    model = spec.compile()
    qpos, qvel = np.zeros(model.nq), np.zeros(model.nv)
    start(model, item, qpos, qvel)
    return [link.pose(qpos) for link in places(model, item)[0]]


def placed(item: Articulated, link: Link) -> tuple[Array, Array]:
    """A link's pose in its parent, or in the world if it has no parent."""
    if link.parent >= 0:
        return link.position, link.quaternion
    position = item.position + rot.rotate(item.quaternion, link.position)
    return position, rot.normalize(rot.multiply(item.quaternion, link.quaternion))
