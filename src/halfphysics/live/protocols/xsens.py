"""Xsens MVN (MVN Analyze, Animate): its network streamer, UDP port 9763, quaternions (MXTP02).

Big-endian; z up, right-handed, x ahead, y to the left; all segments have no rotation in a T-pose
that looks along x. A datagram has a header of 24 bytes and 32 bytes a segment: number (from 1),
position, rotation (w, x, y, z), both in the world; a sample may be split into several. MXTP13 has
the places of the segments at rest. Layout: "MVN real-time network streaming, protocol
specification" (MV0305P). It says centimetres where the user manual says metres, so the unit is seen
by the person's size. A single character is taken: the first one that is heard.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.live.incoming import IncomingPose, Outgoing
from halfphysics.live.protocols.calibration import HEIGHTS, calibrated
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.rig import Rig, standing_height
from halfphysics.live.protocols.udp import UdpReceiver, UdpSender
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Port on which MVN's receivers listen.
PORT = 9763
#: Frames after which the places at rest are sent again.
SKELETON_EVERY = 60

_BODY = (
    *(("Pelvis", "pelvis"), ("L5", "spine1"), ("L3", "spine1"), ("T12", "spine2")),
    *(("T8", "spine3"), ("Neck", "neck"), ("Head", "head")),
    *(
        (f"{side} {segment}", f"{side.lower()}_{joint}")
        for side in ("Right", "Left")
        for segment, joint in (
            *(("Shoulder", "collar"), ("Upper Arm", "shoulder")),
            *(("Forearm", "elbow"), ("Hand", "wrist")),
        )
    ),
    *(
        (f"{side} {segment}", f"{side.lower()}_{joint}")
        for side in ("Right", "Left")
        for segment, joint in (
            *(("Upper Leg", "hip"), ("Lower Leg", "knee")),
            *(("Foot", "ankle"), ("Toe", "foot")),
        )
    ),
)
#: The 23 body segments, and 20 of each hand, in the order of their numbers.
SEGMENTS = tuple(name for name, _ in _BODY)
N_BODY, N_HAND = len(SEGMENTS), 20
# Of a hand's segments (carpus, then metacarpals and phalanges of five fingers) the SMPL-X joints.
_HAND = (
    *("wrist", "thumb1", "thumb2", "thumb3"),
    *(
        joint
        for finger in ("index", "middle", "ring", "pinky")
        for joint in ("wrist", *(f"{finger}{k}" for k in (1, 2, 3)))
    ),
)
_JOINTS = (
    *(joint for _, joint in _BODY),
    *(f"{side}_{joint}" for side in ("left", "right") for joint in _HAND),
)
JOINTS = tuple(JOINT_INDEX[name] for name in _JOINTS)
# The carpus and the metacarpals of fingers turn with the hand, which has a segment of its own.
_FINGERS = np.array([not name.endswith("wrist") for name in _JOINTS[N_BODY:]])
_SEGMENT = struct.Struct(">I7f")
_HEADER = struct.Struct(">4s2sIBBIBBBB2xH")
# The sender's axes from those of the rest pose: z ahead, x left, y up become x, y, z.
_AHEAD = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_LEFT_LEG, _RIGHT_LEG = SEGMENTS.index("Left Upper Leg"), SEGMENTS.index("Right Upper Leg")
# Distance from pelvis to head above which the unit is the centimetre.
_CENTIMETRES = 5.0
_FAR, _LAST = 1e6, 0x80


def receiver(
    endpoint: Endpoint, person: str, body: Body, *, calibrate: float | None = None
) -> UdpReceiver:
    """What receives from MVN's network streamer."""
    return UdpReceiver(endpoint, XsensDecoder(person, body, str(endpoint)), calibrate=calibrate)


def sender(endpoint: Endpoint, person: str, body: Body) -> UdpSender:
    """What sends as MVN's network streamer does."""
    return UdpSender(endpoint, XsensEncoder(person, body))


def plain_rig() -> Rig:
    """Segments that have no rotation in a T-pose which looks along x, in a z-up world."""
    turn = rot.from_matrix(_AHEAD)
    return Rig.of(JOINTS, turns=np.tile(turn, (len(JOINTS), 1)), axes=np.eye(3))


@dataclass(frozen=True)
class Header:
    """The first 24 bytes: what kind of message (2 digits), and of what it is."""

    kind: bytes
    sample: int
    part: int
    items: int
    time: int
    character: int
    bodies: int
    props: int
    fingers: int
    size: int


def header(data: bytes) -> Header:
    """The header of a datagram.

    Raises:
        Malformed: It is no datagram of MVN, or is cut off.
    """
    if len(data) < _HEADER.size:
        raise Malformed(f"xsens: {len(data)} bytes, expected at least {_HEADER.size}")
    magic, *values = _HEADER.unpack_from(data)
    if magic != b"MXTP":
        raise Malformed(f"xsens: found {magic!r}, expected MXTP")
    return Header(*values)


class XsensDecoder:
    """Datagrams to poses of one person."""

    def __init__(self, person: str, body: Body, source: str = "xsens") -> None:
        self._person, self._body, self._source = person, body, source
        self.rig = plain_rig()
        self._character: int | None = None
        self._sample: int | None = None
        self._world = np.tile([1.0, 0.0, 0.0, 0.0], (len(JOINTS), 1))
        self._places = np.zeros((len(JOINTS), 3))
        self._given = np.zeros(len(JOINTS), dtype=bool)
        self._wanted = self._calibrated = False

    def calibrate(self) -> None:
        """Take the next complete pose as a T-pose."""
        self._wanted = True

    def decode(self, data: bytes, now: float) -> list[IncomingPose]:
        """See `Decoder.decode`. Other kinds of messages are passed over."""
        head = header(data)
        payload = data[_HEADER.size :]
        if head.kind not in (b"02", b"13"):
            return []
        if self._character not in (None, head.character):
            return []
        if head.kind == b"13":
            self._rest(payload)
            return []
        if len(payload) != head.items * _SEGMENT.size:
            raise Malformed(f"xsens: {len(payload)} bytes, expected {head.items} segments")
        rows = np.array(list(_SEGMENT.iter_unpack(payload))).reshape(-1, 8)
        if not np.isfinite(rows).all() or np.abs(rows[:, 1:]).max(initial=0.0) > _FAR:
            raise Malformed("xsens: numbers that are not finite or far out of range")
        if (np.square(rows[:, 4:]).sum(axis=1) < 1e-6).any():
            raise Malformed("xsens: a quaternion of zeros")
        self._character = head.character
        if head.sample != self._sample:
            self._sample = head.sample
            self._given[:] = False
        self._put(rows, head.props)
        if not head.part & _LAST or not self._given[0]:
            return []
        return [self._pose(head.time / 1000)]

    def _put(self, rows: Array, props: int) -> None:
        """Segments by their numbers, from 1: body, props, left hand, right hand."""
        index = rows[:, 0].astype(int) - 1
        is_hand = index >= N_BODY + props
        index = np.where(is_hand, index - props, index)
        known = (index >= 0) & (index < len(JOINTS)) & (is_hand | (index < N_BODY))
        index, rows = index[known], rows[known]
        self._world[index] = rot.normalize(rows[:, 4:])
        self._places[index] = rows[:, 1:4]
        self._given[index] = True
        self._given[N_BODY:] &= _FINGERS

    def _pose(self, time: float) -> IncomingPose:
        size = np.linalg.norm(self._places[SEGMENTS.index("Head")] - self._places[0])
        unit = 0.01 if self._given[SEGMENTS.index("Head")] and size > _CENTIMETRES else 1.0
        places = self._places * unit
        if self._wanted:
            self._wanted, self._calibrated = False, True
            left = places[_LEFT_LEG] - places[_RIGHT_LEG]
            self.rig = calibrated(
                self.rig,
                self._world,
                self._body,
                height=float(places[0, 2]),
                left=left if np.linalg.norm(left) > 1e-3 else None,
            )
        pose, tracked = self.rig.pose(self._world, self._given, places[0], self._body)
        return IncomingPose(self._person, pose, time, tracked, self._source)

    def _rest(self, payload: bytes) -> None:
        """The sender's proportions: the directions of its limbs, its size."""
        places = np.zeros((len(JOINTS), 3))
        given = np.zeros(len(JOINTS), dtype=bool)
        (count,), at = _read(payload, 0, ">I")
        for _ in range(min(int(count), 255)):
            (length,), at = _read(payload, at, ">i")
            if not 0 <= length <= len(payload) - at:
                raise Malformed("xsens: a name is cut off")
            name = payload[at : at + int(length)].decode("utf-8", "replace")
            place, at = _read(payload, at + int(length), ">3f")
            if not np.isfinite(place).all() or np.abs(place).max() > _FAR:
                raise Malformed("xsens: places that are not finite or far out of range")
            known = _BY_NAME.get(name.replace(" ", "").lower())
            if known is not None:
                places[known], given[known] = place, True
        if self._calibrated or not given[0]:
            return
        head = SEGMENTS.index("Head")
        far = given[head] and np.linalg.norm(places[head] - places[0]) > _CENTIMETRES
        places *= 0.01 if far else 1.0
        height = float(places[0, 2] - places[given, 2].min())
        # The lowest known place is a toe or an ankle: a T-pose's soles are on the floor, at z = 0.
        height = float(places[0, 2]) if places[0, 2] >= height else height
        scale = standing_height(self._body) / height if HEIGHTS[0] < height < HEIGHTS[1] else 1.0
        still = np.tile([1.0, 0.0, 0.0, 0.0], (len(JOINTS), 1))
        rig = replace(plain_rig(), scale=scale)
        self.rig = rig.aligned(places, still, given, self._body)


_BY_NAME = {name.replace(" ", "").lower(): i for i, name in enumerate(SEGMENTS)}


class XsensEncoder:
    """Frames to datagrams of a person with a body's own proportions; fingers included."""

    def __init__(self, person: str, body: Body) -> None:
        self._person, self._body = person, body
        self._rig = plain_rig()
        up = standing_height(body) - body.rest_joints[0, 1]
        self._rest = body.rest_joints[list(JOINTS[:N_BODY])] + [0.0, up, 0.0]
        self._count = 0

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """See `Encoder.encode`. Nothing is sent of a person who has no pose yet."""
        pose = outgoing.poses.get(self._person)
        if pose is None:
            return []
        packets = []
        if self._count % SKELETON_EVERY == 0:
            packets.append(self._datagram(b"13", outgoing, 0, _LAST, self._skeleton()))
        self._count += 1
        positions, quaternions = self._body.joint_frames(pose)
        rows = np.concatenate(
            [self._rig.places(positions)[list(JOINTS)], self._rig.bones(quaternions)], axis=1
        )
        segments = [_SEGMENT.pack(i, *row) for i, row in enumerate(rows.tolist(), 1)]
        # Within the 1500 bytes of a network: body, then hands.
        parts = [segments[:N_BODY], segments[N_BODY:]]
        for k, part in enumerate(parts):
            last = _LAST if k == len(parts) - 1 else 0
            packets.append(self._datagram(b"02", outgoing, len(part), k | last, b"".join(part)))
        return packets

    def _datagram(
        self, kind: bytes, outgoing: Outgoing, items: int, part: int, payload: bytes
    ) -> bytes:
        time = int(outgoing.time * 1000) % 2**32
        head = _HEADER.pack(
            *(b"MXTP", kind, outgoing.frame % 2**32, part, items, time, 0),
            *(N_BODY, 0, 2 * N_HAND, len(payload)),
        )
        return head + payload

    def _skeleton(self) -> bytes:
        out = [struct.pack(">I", N_BODY)]
        for name, place in zip(SEGMENTS, self._rest @ _AHEAD.T, strict=True):
            data = name.encode()
            out += [struct.pack(">i", len(data)), data, struct.pack(">3f", *place)]
        return b"".join([*out, struct.pack(">I", 0)])


def _read(data: bytes, at: int, layout: str) -> tuple[tuple[float, ...], int]:
    size = struct.calcsize(layout)
    if size > len(data) - at:
        raise Malformed("xsens: the message is cut off")
    return struct.unpack_from(layout, data, at), at + size
