"""What a live session describes, as things to draw: its scene, its people, its contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body import skinning
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.live.client import LiveFrame
from halfphysics.live.schema import Contact, Hello, PersonItem, Pressed, SceneItem
from halfphysics.motion.motion import Motion
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.render.result_meshes import Drawing
from halfphysics.results.soft_contacts import SoftContacts
from halfphysics.scene.scene import Scene
from halfphysics.viewer.contacts import KINDS, NO_PERSON, OBJECT, PERSON, SCENE, FrameContacts, Ints
from halfphysics.viewer.live_dents import unpressed
from halfphysics.viewer.provisional import drawn

Array = NDArray[np.float64]

#: Joints of a person that are farther than this from the default body's [m] have another skin.
_SAME = 0.005


class LivePerson:
    """A person of a session, drawn with the skin of the default body of its stature.

    A session sends no skins: those of licensed models may not leave their machine. The skin follows
    the session's joints.

    Args:
        item: As the session describes them.

    Attributes:
        name: Name.
        body: The body that is drawn.
        own_skin: Whether it is the person's: the session simulates the default body.

    Raises:
        InputError: Not 55 joints, or an impossible stature.
    """

    def __init__(self, item: PersonItem) -> None:
        self.name = item.name
        joints = np.array(item.joints, dtype=np.float64)
        if joints.shape != (N_JOINTS, 3) or not np.isfinite(joints).all():
            raise InputError(
                f"person {item.name!r}: found joints of shape {joints.shape}, expected 55 finite "
                "positions"
            )
        self._joints = joints
        self.body = Body.default(stature=item.stature)
        apart = np.linalg.norm(joints - np.asarray(self.body.rest_joints), axis=1)
        self.own_skin = bool(apart.max() < _SAME)

    def frames(self, pose: Pose) -> tuple[Array, Array]:
        """World frames of the joints: positions (55, 3) [m] and quaternions wxyz (55, 4)."""
        root = (pose.translation + self._joints[0])[None]
        places, turns = skinning.kinematics(pose.rotations[None], root, self._joints)
        return places[0], turns[0]


def drawing_of(hello: Hello, people: Sequence[LivePerson], frame: LiveFrame) -> Drawing:
    """The session at a frame, as a drawing.

    Raises:
        InputError: A scene that cannot be drawn.
    """
    scene = scene_of(hello.statics, hello.objects)
    held = [frame.poses[person.name] for person in people]
    motions = [
        Motion(np.stack([pose.translation] * 2), np.stack([pose.rotations] * 2), hello.fps)
        for pose in held
    ]
    objects = {
        name: frame.objects.get(name, (item.position, item.quaternion))
        for name, item in scene.objects.items()
    }
    names = [*scene.statics, *scene.objects, *(person.name for person in people)]
    result = drawn(motions, [p.body for p in people], scene, objects, names=names)
    vars(result)["dents"] = unpressed(scene)  # as long as nothing presses
    return Drawing(result)


def scene_of(statics: Sequence[SceneItem], objects: Sequence[SceneItem]) -> Scene:
    """The scene of a session. Masses are not looked at: it is only drawn.

    Raises:
        InputError: A shape that is not described in docs/live.md, or an impossible value.
    """
    scene = Scene()
    for item in statics:
        shape, place = _shape(item)
        scene.add_static(item.name, shape, soft=item.soft, **place)
    for item in objects:
        shape, place = _shape(item)
        pieces = "hull" if isinstance(shape, trimesh.Trimesh) else "auto"
        scene.add_object(item.name, shape, mass=1.0, pieces=pieces, soft=item.soft, **place)
    return scene


def pressures_of(pressed: Sequence[Pressed], names: Sequence[str]) -> SoftContacts:
    """The pressures of a frame as a table, whose indices are those of `names`.

    What is of other names is left out: it came before the scene that has it.

    Raises:
        InputError: Numbers that are none, or not as many of each kind.
    """
    known = [one for one in pressed if one.layer in names and one.other in names]
    if not known:
        return SoftContacts.none()
    counts = [len(one.depth) for one in known]
    none = np.full(sum(counts), -1)
    columns: dict[str, Any] = {"frame": none + 1, "part": none, "vertex": none}
    for name in ("layer", "other"):
        index = [list(names).index(getattr(one, name)) for one in known]
        columns[name] = np.repeat(index, counts)
    for name in ("position", "normal", "depth", "pressure", "area"):
        size = (-1, 3) if name in SoftContacts.VECTORS else (-1,)
        try:
            each = [np.array(getattr(one, name), dtype=np.float64).reshape(size) for one in known]
        except ValueError as error:
            raise InputError(f"pressures.{name}: found numbers that do not fit ({error})") from None
        columns[name] = np.concatenate(each)
    return SoftContacts(**columns)


def _shape(item: SceneItem) -> tuple[Any, dict[str, Any]]:
    """A shape and its pose."""
    place = {"position": np.array(item.position), "quaternion": np.array(item.quaternion)}
    kind, given = item.shape.get("kind"), item.shape
    try:
        if kind == "plane":
            return Plane(), place
        if kind == "sphere":
            return Sphere(given["radius"]), place
        if kind == "box":
            return Box(given["size"]), place
        if kind == "capsule":
            return Capsule(given["radius"], given["length"]), place
        if kind == "cylinder":
            return Cylinder(given["radius"], given["length"]), place
        if kind == "bounds":
            low, high = np.array(given["low"], dtype=float), np.array(given["high"], dtype=float)
            middle = rot.rotate(place["quaternion"], 0.5 * (low + high))
            return Box(high - low), {**place, "position": place["position"] + middle}
        if kind == "mesh":
            faces = np.array(given["faces"], dtype=np.int64)
            return trimesh.Trimesh(np.array(given["vertices"], dtype=float), faces), place
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{item.name!r}: found a {kind} that is incomplete ({error})") from None
    raise InputError(f"{item.name!r}: found shape {str(kind)[:40]!r}, expected one of docs/live.md")


class LiveTouches:
    """The contacts of the newest frame of a session, for `ContactNodes`.

    Args:
        statics, people: Names.

    Attributes:
        kind: All kinds: those that will occur are not known yet.
        contacts: Of the newest frame.
    """

    def __init__(self, statics: Sequence[str], people: Sequence[str]) -> None:
        self.kind: Ints = np.arange(len(KINDS))
        self.contacts: Sequence[Contact] = ()
        self._statics, self._people = set(statics), list(people)

    def at(self, frame: int) -> FrameContacts:
        """The contacts of the newest frame."""
        count = len(self.contacts)
        return FrameContacts(
            rows=np.arange(count),
            kind=np.array([self._kind(one) for one in self.contacts], dtype=np.int64),
            position=np.array([one.position for one in self.contacts]).reshape(count, 3),
            force=np.array([one.force for one in self.contacts]).reshape(count, 3),
        )

    def of(self, person: str) -> tuple[Ints, Array, Array]:
        """Parts (n,), positions (n, 3) [m] and sizes of force (n,) [N] on one person."""
        mine = [one for one in self.contacts if one.subject == person and one.part in JOINT_INDEX]
        return (
            np.array([JOINT_INDEX[one.part] for one in mine if one.part], dtype=np.int64),
            np.array([one.position for one in mine]).reshape(len(mine), 3),
            np.linalg.norm(np.array([one.force for one in mine]).reshape(len(mine), 3), axis=1),
        )

    def _kind(self, contact: Contact) -> int:
        if contact.subject not in self._people:
            return NO_PERSON
        if contact.other in self._people:
            return PERSON
        return SCENE if contact.other in self._statics else OBJECT
