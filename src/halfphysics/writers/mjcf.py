"""MJCF with keyframes: the people's 55 parts, the objects, the room; readable by stock MuJoCo.

One file that contains the meshes. Bodies are named as in the scene, those of people "NAME/JOINT".
Keyframe k is frame k: `qpos`, `qvel` (towards the next frame) and, for kinematic objects, the pose
of the mocap body. Collision geometry is convex in MuJoCo: the pieces of objects (group 3 if a mesh
is drawn instead) and convex statics; other meshes are only drawn. MuJoCo gives a pair the larger
friction of its two; pairs with a friction of their own (`Scene.friction`) are pairs there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.atomic import atomic_write
from halfphysics.base.reader_warnings import warn
from halfphysics.body.mjcf_person import (
    add_defaults,
    add_person_elements,
    addresses,
    principal,
    text,
)
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene import articulated as jointed
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.writers.mjcf_geoms import Geoms

if TYPE_CHECKING:
    from halfphysics.scene.articulated import Articulated, Link
    from halfphysics.scene.items import Object
    from halfphysics.writers.take import Take

Array = NDArray[np.float64]
Element = ElementTree.Element

#: MuJoCo's defaults for torsional friction, and for that of rolling about two axes.
_SPIN_AND_ROLL = (0.005, 0.0001, 0.0001)
#: Default class of the people's parts.
_PERSON = "person"


def write(take: Take, path: Path) -> None:
    """Write a take as MJCF.

    Raises:
        FileError: The folder does not exist or cannot be written.
        InputError: MuJoCo cannot compile it.

    Warns:
        HalfPhysicsWarning: Statics that are not convex are drawn and do not collide.
    """
    root = _model(take, path)
    model = _compiled(root, path)
    keyframes = ElementTree.SubElement(root, "keyframe")
    qpos, mocap = _coordinates(take, model)
    for k, (row, speeds) in enumerate(zip(qpos, _velocities(model, qpos, take.fps), strict=True)):
        key = {"time": repr(k / take.fps), "qpos": text(row), "qvel": text(speeds)}
        if model.nmocap:
            key |= {"mpos": text(mocap[k, :, :3].ravel()), "mquat": text(mocap[k, :, 3:].ravel())}
        ElementTree.SubElement(keyframes, "key", key)
    ElementTree.indent(root)
    with atomic_write(path) as handle:
        ElementTree.ElementTree(root).write(handle, encoding="utf-8")


def _model(take: Take, path: Path) -> Element:
    """The model without keyframes."""
    scene = take.scene
    root = ElementTree.Element("mujoco", model=path.stem)
    # A flat visual mesh has moments A + B = C, up to rounding.
    compiler = {"angle": "radian", "autolimits": "true", "balanceinertia": "true"}
    ElementTree.SubElement(root, "compiler", compiler)
    ElementTree.SubElement(root, "option", gravity=text(scene.gravity))
    default = ElementTree.SubElement(root, "default")
    add_defaults(ElementTree.SubElement(default, "default", {"class": _PERSON}))
    assets = ElementTree.SubElement(root, "asset")
    world = ElementTree.SubElement(root, "worldbody")
    geoms = Geoms(assets)
    for actor in take.actors:
        add_person_elements(assets, world, actor.body.variant, f"{actor.name}/", childclass=_PERSON)
    drawn = []
    for name, static in scene.statics.items():
        body = _body(world, name, static.position, static.quaternion)
        if not geoms.solid(body, name, static.shape, static.friction):
            geoms.drawn(body, name, static.shape)
            drawn.append(name)
    if drawn:
        warn(
            f"{path}: {', '.join(drawn)}: not convex, and MuJoCo would collide the hull: drawn, "
            "and touches nothing. Add such things in convex pieces where they are to touch there"
        )
    for name, item in scene.objects.items():
        _object(world, geoms, name, item)
    for whole in scene.articulated.values():
        if _is_recorded(take, whole):
            for link, name in zip(whole.links, whole.link_names, strict=True):
                body = _body(world, name, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
                body.set("mocap", "true")
                _link_geoms(body, geoms, name, link, whole.friction)
        else:
            _articulated(world, geoms, whole)
    _contacts(ElementTree.SubElement(root, "contact"), take, world)
    return root


def _body(parent: Element, name: str, position: Array, quaternion: Array) -> Element:
    return ElementTree.SubElement(
        parent, "body", name=_called(name), pos=text(position), quat=text(quaternion)
    )


def _called(name: str) -> str:
    """The name of a body; MuJoCo reserves one name."""
    return "world/" if name == "world" else name


def _inertial(body: Element, mass: float, com: Array, moments: Array, axes: Array) -> None:
    ElementTree.SubElement(
        body,
        "inertial",
        pos=text(com),
        quat=text(axes),
        mass=text([mass]),
        diaginertia=text(moments),
    )


def _object(world: Element, geoms: Geoms, name: str, item: Object) -> None:
    body = _body(world, name, item.position, item.quaternion)
    if isinstance(item, KinematicObject):
        body.set("mocap", "true")
    else:
        ElementTree.SubElement(body, "freejoint", name=_called(name))
        _inertial(body, item.mass, item.com, *principal(item.inertia))
    seen = item.visual is not None
    for i, piece in enumerate(item.pieces):
        geoms.solid(body, f"{name}/#{i}", piece, item.friction, hidden=seen, convex=True)
    if item.visual is not None:
        geoms.drawn(body, name, item.visual)


def _articulated(world: Element, geoms: Geoms, item: Articulated) -> None:
    """Links and joints as in `scene.articulated.add_bodies`, with other names."""
    bodies: list[Element] = []
    for link, name in zip(item.links, item.link_names, strict=True):
        parent = world if link.parent < 0 else bodies[link.parent]
        body = _body(parent, name, *jointed.placed(item, link))
        bodies.append(body)
        for joint in link.joints:
            said = {"name": f"{item.name}/{joint.name}", "type": joint.kind}
            if joint.kind != "free":
                said["pos"] = text(joint.position)
                said["damping"] = text([joint.damping])
                said["stiffness"] = text([joint.stiffness])
            if joint.kind in ("hinge", "slide"):
                said["axis"] = text(joint.axis)
                said["ref"], said["springref"] = text([joint.reference]), text([joint.springref])
            if joint.limited:
                said["range"] = text([joint.lower, joint.upper])
            said["armature"] = text([joint.armature])
            ElementTree.SubElement(body, "joint", said)
        if link.mass > 0.0:
            _inertial(body, link.mass, link.com, link.inertia, link.inertia_quaternion)
        _link_geoms(body, geoms, name, link, item.friction)


def _link_geoms(body: Element, geoms: Geoms, name: str, link: Link, friction: float) -> None:
    for i, geom in enumerate(link.geoms):
        place = geom.position, geom.quaternion
        geoms.solid(body, f"{name}/#{i}", geom.shape, friction, *place, convex=True)


def _is_recorded(take: Take, item: Articulated) -> bool:
    """Whether the poses of its links are known, but not the values of all its joints."""
    moving = any(prop.moves and prop.name in item.link_names for prop in take.props)
    joints = [f"{item.name}/{joint.name}" for link in item.links for joint in link.joints]
    return moving and not all(name in take.joints for name in joints)


def _contacts(contact: Element, take: Take, world: Element) -> None:
    """Pairs that do not collide (those that the scene ignores, links of one object), and pairs of a
    friction of their own."""
    scene = take.scene
    bodies = {name: [_called(name)] for name in (*scene.statics, *scene.objects)}
    ignored = list(scene.ignored_pairs)
    for item in scene.articulated.values():
        bodies[item.name] = list(item.link_names)
        ignored.append((item.name, item.name))
    for joint in JOINT_NAMES:
        bodies[f"person/{joint}"] = [f"{actor.name}/{joint}" for actor in take.actors]
    bodies["person"] = [name for joint in JOINT_NAMES for name in bodies[f"person/{joint}"]]
    solid = {
        body.attrib["name"]: [geom.attrib["name"] for geom in body.findall("geom[@name]")]
        for body in world.iter("body")
    }
    apart = {pair for a, b in ignored for pair in _pairs(bodies[a], bodies[b])}
    for first, second in sorted(apart):
        ElementTree.SubElement(contact, "exclude", body1=first, body2=second)
    fixed = {_called(name) for name in scene.statics}
    own: dict[tuple[str, str], float] = {}
    # What is said of parts holds instead of what is said of all people.
    for a, b, mu in sorted(scene.friction_pairs, key=lambda pair: (pair[0] + pair[1]).count("/")):
        for pair in set(_pairs(bodies[a], bodies[b])) - apart:
            if not fixed.issuperset(pair):
                own[pair] = mu
    for (first, second), mu in sorted(own.items()):
        friction = text([mu, mu, *_SPIN_AND_ROLL])
        for one in solid[first]:
            for other in solid[second]:
                both = {"geom1": one, "geom2": other}
                ElementTree.SubElement(contact, "pair", both, friction=friction)


def _pairs(these: Sequence[str], those: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Every two of different names, each once, in the order of their names."""
    for first in these:
        for second in those:
            if first != second:
                yield min(first, second), max(first, second)


def _compiled(root: Element, path: Path) -> Any:
    import mujoco

    try:
        return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: MuJoCo cannot compile this scene: {reason}") from None


def _coordinates(take: Take, model: Any) -> tuple[Array, Array]:
    """Coordinates (T, nq) and poses of mocap bodies (T, nmocap, 7) of all frames."""
    qpos = np.tile(np.asarray(model.qpos0, dtype=np.float64), (take.frames, 1))
    mocap = np.zeros((take.frames, model.nmocap, 7))
    for actor in take.actors:
        at = addresses(model, f"{actor.name}/")
        joints, _ = actor.body.joint_frames(actor.motion)
        qpos[:, at.root_position : at.root_position + 3] = joints[:, 0]
        qpos[:, at.quat[:, None] + np.arange(4)] = rot.exp(actor.motion.rotations)
    for prop in take.props:
        place = np.hstack([prop.position, prop.quaternion])
        body = model.body(_called(prop.name))
        if int(body.mocapid[0]) >= 0:
            mocap[:, int(body.mocapid[0])] = place
        elif prop.name in take.scene.objects:
            first = int(model.jnt_qposadr[int(body.jntadr[0])])
            qpos[:, first : first + 7] = place
    for item in take.scene.articulated.values():
        if _is_recorded(take, item):
            continue
        for link in item.links:
            for joint in link.joints:
                name = f"{item.name}/{joint.name}"
                first = int(model.joint(name).qposadr[0])
                count = jointed.SIZES[joint.kind][0]
                start = jointed.start_of(item, link, joint)
                values = np.asarray(take.joints.get(name, start), dtype=np.float64)
                qpos[:, first : first + count] = values.reshape(-1, count)
    return qpos, mocap


def _velocities(model: Any, qpos: Array, fps: float) -> Array:
    """Velocities (T, nv) from each frame to the next; the last frame repeats the one before."""
    import mujoco

    qvel = np.zeros((len(qpos), model.nv))
    for k in range(len(qpos) - 1):
        mujoco.mj_differentiatePos(model, qvel[k], 1.0 / fps, qpos[k], qpos[k + 1])
    qvel[-1] = qvel[-2]
    return qvel
