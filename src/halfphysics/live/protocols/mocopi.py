"""mocopi (Sony): what its app sends to a computer, UDP port 12351, 27 bones.

Fields of length (u32), name (4 letters) and value, little-endian, within each other. First comes
a skeleton (``skdf``): of each bone its parent, and rotation and position at rest; then frames
(``fram``). Rotations (x, y, z, w) and positions [m] are in the parent's frame, right-handed, y up,
z ahead: Sony's plug-in for Unity mirrors them at x = 0. Layout: seagetch/mcp-receiver,
doc/Protocol.md, and what others measured (the widths of ``time``, ``uttm``, ``tmcd``).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.live.incoming import IncomingPose, Outgoing
from halfphysics.live.protocols.calibration import HEIGHTS, calibrated
from halfphysics.live.protocols.chain import Chain
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.rig import Rig, standing_height
from halfphysics.live.protocols.udp import UdpReceiver, UdpSender
from halfphysics.motion.skeleton import JOINT_INDEX

Array = NDArray[np.float64]

#: Port on which receivers listen.
PORT = 12351
#: Frames after which the skeleton is sent again, for receivers that came later.
SKELETON_EVERY = 60

_SPINE = (("spine1", 2), ("spine2", 2), ("spine3", 3), ("neck", 2), ("head", 1))
_ARM, _LEG = ("collar", "shoulder", "elbow", "wrist"), ("hip", "knee", "ankle", "foot")
#: The SMPL-X joint that each bone turns with: root, torso 1 to 7, neck 1 and 2, head, arms, legs.
_JOINTS = (
    "pelvis",
    *(joint for joint, count in _SPINE for _ in range(count)),
    *(f"{side}_{joint}" for side in ("left", "right") for joint in _ARM),
    *(f"{side}_{joint}" for side in ("left", "right") for joint in _LEG),
)
JOINTS = tuple(JOINT_INDEX[name] for name in _JOINTS)
#: Parent of each bone: arms and neck on torso 7, legs on the root.
PARENTS = (
    *(-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9),
    *(7, 11, 12, 13, 7, 15, 16, 17),
    *(0, 19, 20, 21, 0, 23, 24, 25),
)
N_BONES = len(JOINTS)
_LEFT_LEG, _RIGHT_LEG = 19, 23
_FAR = 1e4


def receiver(
    endpoint: Endpoint, person: str, body: Body, *, calibrate: float | None = None
) -> UdpReceiver:
    """What receives from the app."""
    return UdpReceiver(endpoint, MocopiDecoder(person, body, str(endpoint)), calibrate=calibrate)


def sender(endpoint: Endpoint, person: str, body: Body) -> UdpSender:
    """What sends as the app does."""
    return UdpSender(endpoint, MocopiEncoder(person, body))


def fields(data: bytes) -> list[tuple[bytes, bytes]]:
    """Names and values of the fields in `data`.

    Raises:
        Malformed: One is longer than what is left.
    """
    found, at = [], 0
    while at < len(data):
        if len(data) - at < 8:
            raise Malformed(f"mocopi: {len(data) - at} bytes where a field should begin")
        (size,) = struct.unpack_from("<I", data, at)
        if size > len(data) - at - 8:
            raise Malformed(f"mocopi: a field of {size} bytes where {len(data) - at - 8} are left")
        found.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 8 + size
    return found


def field(name: bytes, value: bytes) -> bytes:
    """A field."""
    return struct.pack("<I", len(value)) + name + value


class MocopiDecoder:
    """Packets to poses of one person."""

    def __init__(self, person: str, body: Body, source: str = "mocopi") -> None:
        self._person, self._body, self._source = person, body, source
        self.rig = Rig.of(JOINTS)
        self._chain = Chain(PARENTS)
        self._skeleton: tuple[Array, Array] | None = None
        self._wanted = self._calibrated = False

    def calibrate(self) -> None:
        """Take the next complete pose as a T-pose."""
        self._wanted = True

    def decode(self, data: bytes, now: float) -> list[IncomingPose]:
        """See `Decoder.decode`."""
        top = dict(fields(data))
        head = dict(fields(_needed(top, b"head")))
        if _needed(head, b"ftyp") != b"sony motion format":
            raise Malformed("mocopi: it is not the sony motion format")
        if b"skdf" in top:
            self._take_skeleton(_needed(dict(fields(top[b"skdf"])), b"bons"))
            return []
        frame = dict(fields(_needed(top, b"fram")))
        (time,) = _unpacked("<f", _needed(frame, b"time"))
        local, offsets, given = _bones(_needed(frame, b"btrs"), b"btdt")
        if not given[0]:
            return []
        world = self._chain.world_rotations(local)
        if self._wanted:
            self._calibrate(world, offsets)
        pose, tracked = self.rig.pose(world, given, offsets[0], self._body)
        return [IncomingPose(self._person, pose, time, tracked, self._source)]

    def _take_skeleton(self, bones: bytes) -> None:
        """The sender's rest pose: its bones' axes there, the directions of its limbs, its size."""
        local, offsets, given = _bones(bones, b"bndt")
        known = self._skeleton
        same = known is not None and all(map(np.array_equal, known, (local, offsets)))
        if not given.all() or same or self._calibrated:
            return
        self._skeleton = local, offsets
        world = self._chain.world_rotations(local)
        places = self._chain.world_positions(world, offsets)
        height = float(offsets[0, 1])
        known_height = HEIGHTS[0] < height < HEIGHTS[1]
        scale = standing_height(self._body) / height if known_height else 1.0
        plain = Rig.of(JOINTS, turns=rot.conjugate(world))
        rig = Rig(plain.joints, plain.turns, plain.axes, scale)
        self.rig = rig.aligned(places, world, given, self._body)

    def _calibrate(self, world: Array, offsets: Array) -> None:
        self._wanted, self._calibrated = False, True
        places = self._chain.world_positions(world, offsets)
        left = places[_LEFT_LEG] - places[_RIGHT_LEG]
        self.rig = calibrated(
            self.rig,
            world,
            self._body,
            height=float(offsets[0, 1]),
            left=left if np.linalg.norm(left) > 1e-3 else None,
        )


class MocopiEncoder:
    """Frames to packets of a person with a body's own proportions."""

    def __init__(self, person: str, body: Body) -> None:
        self._person, self._body = person, body
        self._rig, self._chain = Rig.of(JOINTS), Chain(PARENTS)
        rest = _rest_places(body.rest_joints)
        self._offsets = self._chain.offsets(rest)
        self._offsets[0] = [0.0, standing_height(body), 0.0]
        self._count = 0

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """See `Encoder.encode`. Nothing is sent of a person who has no pose yet."""
        pose = outgoing.poses.get(self._person)
        if pose is None:
            return []
        packets = [self._skeleton()] if self._count % SKELETON_EVERY == 0 else []
        positions, quaternions = self._body.joint_frames(pose)
        local = self._chain.local_rotations(self._rig.bones(quaternions))
        offsets = self._offsets.copy()
        offsets[0] = self._rig.places(positions[0])
        frame = (
            field(b"fnum", struct.pack("<I", outgoing.frame % 2**32))
            + field(b"time", struct.pack("<f", outgoing.time))
            + field(b"uttm", struct.pack("<d", outgoing.clock))
            + field(b"tmcd", bytes(6))
            + field(b"btrs", _records(b"btdt", local, offsets, None))
        )
        self._count += 1
        return [*packets, _BEGIN + field(b"fram", frame)]

    def _skeleton(self) -> bytes:
        still = np.tile([1.0, 0.0, 0.0, 0.0], (N_BONES, 1))
        records = _records(b"bndt", still, self._offsets, PARENTS)
        return _BEGIN + field(b"skdf", field(b"bons", records))


_BEGIN = field(b"head", field(b"ftyp", b"sony motion format") + field(b"vrsn", bytes([1]))) + field(
    b"sndf", field(b"ipad", bytes(8)) + field(b"rcvp", struct.pack("<H", PORT))
)


def _records(name: bytes, local: Array, offsets: Array, parents: Sequence[int] | None) -> bytes:
    out = []
    rows = np.concatenate([local[:, [1, 2, 3, 0]], offsets], axis=1).tolist()
    for bone, row in enumerate(rows):
        parent = b"" if parents is None else field(b"pbid", struct.pack("<h", parents[bone]))
        number = field(b"bnid", struct.pack("<H", bone))
        out.append(field(name, number + parent + field(b"tran", struct.pack("<7f", *row))))
    return b"".join(out)


def _bones(data: bytes, name: bytes) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Rotations (27, 4) and positions (27, 3) in the parents' frames, and bones given (27,)."""
    rows = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (N_BONES, 1))
    given = np.zeros(N_BONES, dtype=bool)
    for kind, value in fields(data):
        if kind != name:
            continue
        record = dict(fields(value))
        bone = int(_unpacked("<H", _needed(record, b"bnid"))[0])
        row = _unpacked("<7f", _needed(record, b"tran"))
        if bone >= N_BONES:
            continue  # of another skeleton
        # NaN is not below anything: such a bone is lost, as if it were not there.
        if all(abs(x) < _FAR for x in row) and sum(x * x for x in row[:4]) > 1e-6:
            rows[bone] = row
            given[bone] = True
    return rot.normalize(rows[:, [3, 0, 1, 2]]), rows[:, 4:], given


def _needed(found: dict[bytes, bytes], name: bytes) -> bytes:
    if name not in found:
        raise Malformed(f"mocopi: no {name.decode()}")
    return found[name]


def _unpacked(layout: str, value: bytes) -> tuple[float, ...]:
    if len(value) != struct.calcsize(layout):
        raise Malformed(f"mocopi: {len(value)} bytes, expected {struct.calcsize(layout)}")
    numbers = struct.unpack(layout, value)
    if layout == "<f" and not np.isfinite(numbers).all():
        raise Malformed("mocopi: a time that is not finite")
    return numbers


def _rest_places(rest: Array) -> Array:
    """Where the bones are at rest (27, 3): several of one joint share the way to the next one."""
    places = rest[list(JOINTS)].copy()
    bone = 1
    ends = [JOINT_INDEX[name] for name in ("spine2", "spine3", "neck", "head")]
    for (joint, count), end in zip(_SPINE[:4], ends, strict=True):
        start = rest[JOINT_INDEX[joint]]
        for k in range(count):
            places[bone] = start + (rest[end] - start) * (k / count)
            bone += 1
    return places
