"""The messages of a live session, version 1; docs/live.md is their description for others.

The same messages travel as JSON (text frames) and as MessagePack (binary frames). What a client
sends is checked here: unknown fields are ignored, wrong types, lengths and numbers are refused.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal, cast

import msgspec
from msgspec import UNSET, Meta, Struct, UnsetType

from halfphysics.errors import InputError
from halfphysics.live.bounds import LIMITS
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

#: Version of the schema. A change that old clients cannot read makes a new one.
VERSION = 1
#: WebSocket subprotocols: how the server encodes what it sends. A client that asks for none gets
#: JSON. Either kind of frame is understood from every client.
JSON_PROTOCOL, MSGPACK_PROTOCOL = f"halfphysics.v{VERSION}.json", f"halfphysics.v{VERSION}.msgpack"
#: Largest message that a client may send [bytes].
MAX_MESSAGE = 65_536
#: Largest distance from the origin [m], and largest rotation vector [rad]: beyond two turns it is
#: no rotation vector but a unit mistaken.
MAX_DISTANCE, MAX_ROTATION = 1000.0, 4.0 * 3.1416
#: Most people in one pose message.
MAX_PEOPLE = 32

UNITS = {"length": "m", "angle": "rad", "time": "s", "mass": "kg", "force": "N", "impulse": "N s"}
AXES = "right-handed, z up"

Name = Annotated[str, Meta(min_length=1, max_length=100)]
#: A client's clock [s], of any origin: any finite number.
Time = Annotated[float, Meta(ge=-1e300, le=1e300)]
Metres = Annotated[float, Meta(ge=-MAX_DISTANCE, le=MAX_DISTANCE)]
Radians = Annotated[float, Meta(ge=-MAX_ROTATION, le=MAX_ROTATION)]
Point = tuple[Metres, Metres, Metres]
Rotation = tuple[Radians, Radians, Radians]
Rotations = Annotated[list[Rotation], Meta(min_length=55, max_length=55)]
Tracked = Annotated[list[bool], Meta(min_length=55, max_length=55)]
Quaternion = tuple[float, float, float, float]
#: What a client calls a message: MessagePack has whole numbers of 64 bits.
Id = Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)] | str | None

#: Parts of a frame that a client can subscribe to.
Part = Literal["poses", "targets", "objects", "joints", "contacts", "pressures"]
PARTS: tuple[Part, ...] = ("poses", "targets", "objects", "joints", "contacts", "pressures")
#: Those of who does not name any: pressures are ten times as much as all else.
USUAL_PARTS: tuple[Part, ...] = PARTS[:-1]


class PersonPose(Struct):
    """One person in a pose message."""

    translation: Point
    rotations: Rotations
    tracked: Tracked | None = None


class PoseMessage(Struct, tag="pose"):
    """Poses of people who were measured at one moment: they are stepped together."""

    people: Annotated[dict[Name, PersonPose], Meta(min_length=1, max_length=MAX_PEOPLE)]
    time: Time | None = None


class Add(Struct, tag_field="action", tag="add"):
    """An object of a simple shape: "sphere:0.11", "box:0.4:0.3:0.2", "capsule:0.1:0.5"."""

    name: Name
    shape: Annotated[str, Meta(max_length=100)]
    mass: float
    position: Point
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    friction: float | None = None
    restitution: float | None = None


class Remove(Struct, tag_field="action", tag="remove"):
    """Take an object away."""

    name: Name


class Drag(Struct, tag_field="action", tag="drag"):
    """Pull an object by a point.

    The first drag takes hold at `grip` (or at the pointer), the next ones move the pointer; null
    lets go.
    """

    name: Name
    pointer: Point | None
    grip: Point | None = None


class Mass(Struct, tag_field="action", tag="mass"):
    """Another mass [kg] of an object."""

    name: Name
    value: float


class Friction(Struct, tag_field="action", tag="friction"):
    """Another coefficient of friction of a static or an object."""

    name: Name
    value: float


class Stiffness(Struct, tag_field="action", tag="stiffness"):
    """Stiffness of a person's joints (null: everybody's), one number or by joint group."""

    value: float | Annotated[dict[str, float], Meta(max_length=100)]
    person: Name | None = None


class Impulse(Struct, tag_field="action", tag="impulse"):
    """Push an object [N s], at a point or at its centre of mass."""

    name: Name
    impulse: tuple[float, float, float]
    point: Point | None = None


Action = Add | Remove | Drag | Mass | Friction | Stiffness | Impulse


class Edit(Struct, tag="edit"):
    """A change of the scene, before the next step. Answered by `Done` or `ErrorMessage`."""

    edit: Action
    id: Id = None


class Subscribe(Struct, tag="subscribe"):
    """Which parts of frames to send, of which people, and how often.

    Defaults: everything but pressures, of everybody, every frame. A rate of 0 sends none.
    """

    parts: Annotated[list[Part], Meta(max_length=len(PARTS))] | None = None
    people: Annotated[list[Name], Meta(max_length=MAX_PEOPLE)] | None = None
    rate: Annotated[float, Meta(ge=0.0, le=1000.0)] | None = None
    id: Id = None


class Ping(Struct, tag="ping"):
    """Answered at once, with the server's clock."""

    id: Id = None
    time: Time | None = None


class ClientHello(Struct, tag="hello"):
    """May come first: the version that the client speaks, and its name for the server's log."""

    version: int
    name: Annotated[str, Meta(max_length=100)] = ""


FromClient = ClientHello | PoseMessage | Edit | Subscribe | Ping


class PersonItem(Struct):
    """A person of the session.

    `joints`: rest positions of the 55 joints in the body's own axes (y up) [m].
    """

    name: str
    stature: float
    mass: float
    joints: list[list[float]]


class SceneItem(Struct, omit_defaults=True):
    """A static or an object.

    `shape`: {"kind": "sphere", "radius": ...} and so on, see docs/live.md. `mass` 0: it does not
    move, or on a trajectory. `soft`: the fields of `Soft`; None: it is hard.
    """

    name: str
    shape: dict[str, Any]
    position: list[float]
    quaternion: list[float]
    friction: float
    mass: float = 0.0
    soft: dict[str, Any] | None = None


class Hello(Struct, tag="hello"):
    """The first message of the server."""

    version: int
    server: str
    fps: float
    people: list[PersonItem]
    statics: list[SceneItem]
    objects: list[SceneItem]
    joints: list[str]
    parents: list[int]
    units: dict[str, str]
    axes: str
    clock: float
    limits: dict[str, float]


class SceneMessage(Struct, tag="scene"):
    """What is in the scene now; sent to everybody after an edit that changed it."""

    statics: list[SceneItem]
    objects: list[SceneItem]


class StampItem(Struct):
    """The way of the newest pose: see `live.incoming.Stamp`."""

    sent: float | None
    received: float
    stepped: float


class PersonFrame(Struct):
    """A person in a frame. Fields of parts that are not subscribed to are missing."""

    tracking: str
    stamp: StampItem | None = None
    translation: list[float] | UnsetType = UNSET
    rotations: list[list[float]] | UnsetType = UNSET
    target_translation: list[float] | UnsetType = UNSET
    target_rotations: list[list[float]] | UnsetType = UNSET


class Place(Struct):
    """Where an object or link is."""

    position: list[float]
    quaternion: list[float]


class Contact(Struct):
    """A pair that touched during the frame; of two people each has a row.

    `subject`: name of the person or object that is touched by `other`; parts are joint names, null
    for objects. `normal` points from the other into the subject; `force` [N] acts on the subject.
    """

    subject: str
    part: str | None
    other: str
    other_part: str | None
    position: list[float]
    normal: list[float]
    force: list[float]


class Pressed(Struct):
    """Samples of one thing or person that press another, which gives way, at the end of a frame.

    `layer` gives way, `other` has the samples; of each: its `position` [m], the `normal` out of the
    layer, and the `depth` [m], `pressure` [Pa] and `area` [m^2] of `SoftContacts`.
    """

    layer: str
    other: str
    position: list[list[float]]
    normal: list[list[float]]
    depth: list[float]
    pressure: list[float]
    area: list[float]


class FrameMessage(Struct, tag="frame"):
    """One frame of the simulation."""

    frame: int
    time: float
    clock: float
    clearance: float | None
    people: dict[str, PersonFrame]
    objects: dict[str, Place] | UnsetType = UNSET
    joints: dict[str, float | list[float]] | UnsetType = UNSET
    contacts: list[Contact] | UnsetType = UNSET
    pressures: list[Pressed] | UnsetType = UNSET


class Done(Struct, tag="done"):
    """An edit or a subscription was carried out."""

    id: Id


class ErrorMessage(Struct, tag="error"):
    """A message was refused; `message` says what was found, what was expected, the way out."""

    code: Literal["invalid", "refused", "version", "busy"]
    message: str
    id: Id = None


class Pong(Struct, tag="pong"):
    """Answer to `Ping`: its id and time, and the server's clock [s]."""

    id: Id
    time: float | None
    clock: float


FromServer = Hello | SceneMessage | FrameMessage | Done | ErrorMessage | Pong


class _Numbered(Struct):
    """Of any message its number."""

    id: Id = None


_NUMBERED = (msgspec.json.Decoder(_Numbered), msgspec.msgpack.Decoder(_Numbered))
_FROM_CLIENT = (msgspec.json.Decoder(FromClient), msgspec.msgpack.Decoder(FromClient))
_FROM_SERVER = (msgspec.json.Decoder(FromServer), msgspec.msgpack.Decoder(FromServer))
_JSON, _MSGPACK = msgspec.json.Encoder(), msgspec.msgpack.Encoder()


def hello(
    *,
    server: str,
    fps: float,
    people: list[PersonItem],
    statics: list[SceneItem],
    objects: list[SceneItem],
    clock: float,
) -> Hello:
    """The first message of a server; see `Hello`."""
    return Hello(
        version=VERSION,
        server=server,
        fps=fps,
        people=people,
        statics=statics,
        objects=objects,
        joints=list(JOINT_NAMES),
        parents=PARENTS.tolist(),
        units=UNITS,
        axes=AXES,
        clock=clock,
        limits={
            "message_bytes": MAX_MESSAGE,
            "position": MAX_DISTANCE,
            "rotation": MAX_ROTATION,
            "people": MAX_PEOPLE,
            **LIMITS,
        },
    )


def encode(message: Struct, binary: bool) -> bytes:
    """A message as MessagePack (`binary`) or as JSON in UTF-8."""
    return _MSGPACK.encode(message) if binary else _JSON.encode(message)


def from_client(data: str | bytes) -> FromClient:
    """A client's message: text is JSON, bytes are MessagePack.

    Raises:
        InputError: It is none of version 1.
    """
    decoder: Any = _FROM_CLIENT[not isinstance(data, str)]
    try:
        message: FromClient = decoder.decode(data)
        return message
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        raise InputError(_wrong(data, error)) from None


def number_of(data: str | bytes) -> Id:
    """The `id` of a client's message that may be none of version 1; None if it has none."""
    decoder: Any = _NUMBERED[not isinstance(data, str)]
    try:
        return cast("_Numbered", decoder.decode(data)).id
    except (msgspec.MsgspecError, UnicodeError, RecursionError):
        return None


def from_server(data: str | bytes) -> FromServer:
    """A server's message.

    Raises:
        InputError: It is none of version 1.
    """
    decoder: Any = _FROM_SERVER[not isinstance(data, str)]
    try:
        message: FromServer = decoder.decode(data)
        return message
    except (msgspec.MsgspecError, UnicodeError, RecursionError) as error:
        raise InputError(_wrong(data, error)) from None


#: Text of JSON; or what some programs write into JSON for numbers that are none.
_TEXT_OR_NOT_FINITE = re.compile(r'"(?:[^"\\]|\\.)*"?|-?\b(?:NaN|Infinity)\b', re.DOTALL)
_OF_A_POSE = re.compile(r'"type"\s*:\s*"pose"')


def _wrong(data: str | bytes, error: Exception) -> str:
    kind, said = "JSON" if isinstance(data, str) else "MessagePack", str(error)[:300]
    # A field that is wrong was found before the number was read, and is what is wrong.
    if isinstance(data, str) and not isinstance(error, msgspec.ValidationError):
        said += _about_numbers(data)
    return (
        f"message: found {kind} of {len(data)} characters that is no message of version "
        f"{VERSION}: {said}. docs/live.md describes the messages"
    )


def _about_numbers(data: str) -> str:
    """What to add of a number that is none, outside of text; "": there is no such number."""
    found = (match[0] for match in _TEXT_OR_NOT_FINITE.finditer(data))
    odd = next((one for one in found if not one.startswith('"')), None)
    if odd is None:
        return ""
    advice = "; joints that are not known are false in 'tracked'" if _OF_A_POSE.search(data) else ""
    return f" ({odd} is no number of JSON{advice})"
