"""VMC 3.1 (protocol.vmc.info): OSC over UDP, between VSeeFace, SlimeVR, Unity, Unreal, Blender.

A performer sends ``/VMC/Ext/Root/Pos`` and one ``/VMC/Ext/Bone/Pos`` for each of Unity's
`HumanBodyBones`: position and rotation in the parent's frame, in Unity's axes [m], x, y, z, w. A
marionette receives them, on port 39539. Here a live session is both: it listens as a marionette,
and sends the corrected poses on as a performer.

A frame is not marked. It is complete when all bones of the frames before have come. A bone that
comes again begins the next one; so does the bone that began the frame before, if the bones come in
the same order: packets may be lost.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.live.incoming import IncomingPose, Outgoing
from halfphysics.live.protocols import humanoid, osc, unity
from halfphysics.live.protocols.calibration import HEIGHTS, calibrated
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.osc import Message
from halfphysics.live.protocols.rig import Rig
from halfphysics.live.protocols.udp import UdpReceiver, UdpSender
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Port on which a marionette listens.
PORT = 39539
#: Largest packet that is sent [bytes].
MAX_PACKET = 1500
#: Largest number of devices (headsets, controllers, trackers) that are kept.
MAX_DEVICES = 64

_BONE, _ROOT, _TIME = "/VMC/Ext/Bone/Pos", "/VMC/Ext/Root/Pos", "/VMC/Ext/T"
_OK, _CALIBRATE = "/VMC/Ext/OK", "/VMC/Ext/Set/Calib/Exec"
_DEVICES = {
    f"/VMC/Ext/{kind}/Pos{local}": kind
    for kind in ("Hmd", "Con", "Tra")
    for local in ("", "/Local")
}
#: Frames whose bones are expected in the next one: a bone that none of them has is sent no more.
_RECENT = 3
_ANKLES = [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]
_LEFT_HIP, _RIGHT_HIP = JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]
# A bone whose place changes by more shows another model [m]; largest coordinate that is taken [m].
_MOVED, _FAR = 1e-3, 1e4
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
# No place and no rotation, as they are sent.
_REST = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def receiver(
    endpoint: Endpoint, person: str, body: Body, *, calibrate: float | None = None
) -> UdpReceiver:
    """A marionette."""
    return UdpReceiver(endpoint, VmcDecoder(person, body, str(endpoint)), calibrate=calibrate)


def sender(endpoint: Endpoint, person: str, body: Body) -> UdpSender:
    """A performer."""
    return UdpSender(endpoint, VmcEncoder(person, body))


@dataclass(frozen=True, eq=False)
class Device:
    """A headset, controller or tracker.

    Attributes:
        kind: "Hmd", "Con" or "Tra".
        position: In the world [m], (3,).
        quaternion: World from device (4,).
        raw: Whether the sender did not fit it to the size of its model.
    """

    kind: str
    position: Array
    quaternion: Array
    raw: bool


@dataclass(eq=False)
class _Frame:
    """What has come of a frame: of each bone position and rotation as they were sent (55, 7).

    `order`: the joints in the order in which they came.
    """

    rows: Array = field(default_factory=lambda: np.tile(_REST, (N_JOINTS, 1)))
    given: Bools = field(default_factory=lambda: np.zeros(N_JOINTS, dtype=bool))
    order: list[int] = field(default_factory=list)
    done: bool = False


class VmcDecoder:
    """Packets to poses of one person.

    Attributes:
        devices: Serial -> the headset, controller or tracker as it was sent last.
        status: Arguments of the last /VMC/Ext/OK: loaded, and what is known of calibration.
        rig: As it was calibrated, or found from the model's own rest pose.
    """

    def __init__(self, person: str, body: Body, source: str = "vmc") -> None:
        self._person, self._body, self._source = person, body, source
        self.devices: dict[str, Device] = {}
        self.status: tuple[int, ...] = ()
        self.rig = Rig.of(range(N_JOINTS))
        self._root = (np.zeros(3), _IDENTITY)
        self._time: float | None = None
        self._frame = _Frame()
        self._recent: deque[Bools] = deque(maxlen=_RECENT)
        self._order: list[int] = []  # in which the bones of a frame come
        # Of the model that the rig is fitted to: places of its bones (55, 3), and which have come.
        self._offsets = np.zeros((N_JOINTS, 3))
        self._seen = np.zeros(N_JOINTS, dtype=bool)
        self._calibrated = self._wanted = False

    def calibrate(self) -> None:
        """Take the next pose that no bone is missing of as a T-pose."""
        self._wanted = True

    def decode(self, data: bytes, now: float) -> list[IncomingPose]:
        """See `Decoder.decode`."""
        checked = [(message, _checked(message)) for message in osc.decode(data)]
        return [pose for message, values in checked for pose in self._take(message, values)]

    def _take(self, message: Message, values: Array | None) -> list[IncomingPose]:
        address = message.address
        if address == _BONE and values is not None:
            return self._bone(str(message.arguments[0]), values)
        if address == _ROOT and values is not None:
            self._root = (unity.position(values[:3]), rot.normalize(unity.from_xyzw(values[3:])))
        elif address in _DEVICES and values is not None:
            self._device(address, str(message.arguments[0]), values)
        elif address == _TIME:
            self._time = float(message.arguments[0])
        elif address == _OK:
            self.status = tuple(int(value) for value in message.arguments)
        elif address == _CALIBRATE:
            self.calibrate()
        return []

    def _bone(self, name: str, values: Array) -> list[IncomingPose]:
        joint = humanoid.INDEX_OF.get(name.lower())
        if joint is None:  # LastBone, and bones of other models
            return []
        poses = []
        if self._begins(joint):
            if not self._frame.done:  # it lacks bones that the ones before had
                poses += self._complete()
            if self._is_whole():
                self._order = self._frame.order
            self._recent.append(self._frame.given)
            self._frame = _Frame()
        frame = self._frame
        frame.rows[joint] = values
        frame.given[joint] = True
        frame.order.append(joint)
        if not frame.done and self._recent and self._is_whole():
            poses += self._complete()
        return poses

    def _begins(self, joint: int) -> bool:
        """Whether the bone is the first of the next frame."""
        frame = self._frame
        if frame.given[joint]:
            return True
        if not frame.order or self._order[:1] != [joint]:
            return False
        # The first bone of a frame: that of this one was lost, unless the order is another now.
        known = [other for other in self._order if frame.given[other]]
        return known == [other for other in frame.order if other in self._order]

    def _is_whole(self) -> bool:
        """Whether the present frame has all bones of the last frames."""
        return all(bool(self._frame.given[given].all()) for given in self._recent)

    def _complete(self) -> list[IncomingPose]:
        frame = self._frame
        frame.done = True
        if not frame.given[0]:
            return []
        root_at, root = self._root
        local = rot.normalize(unity.from_xyzw(frame.rows[:, 3:]))
        local[0] = rot.multiply(root, local[0])
        world = humanoid.CHAIN.world_rotations(local)
        offsets = unity.position(frame.rows[:, :3])
        offsets[0] = root_at + rot.rotate(root, offsets[0])
        self._fit(frame, world, offsets)
        # A bone that is missing is at rest on the one above, so what hangs on it is turned rightly.
        pose, _ = self.rig.pose(world, self._seen | frame.given, offsets[0], self._body)
        return [IncomingPose(self._person, pose, self._time, frame.given.copy(), self._source)]

    def _fit(self, frame: _Frame, world: Array, offsets: Array) -> None:
        """Calibrate if it was asked for; else the limbs of a model are along its own rest pose."""
        if self._wanted and self._is_whole():
            self._wanted, self._calibrated = False, True
            places = humanoid.CHAIN.world_positions(world, offsets)
            hips = frame.given[[_LEFT_HIP, _RIGHT_HIP]].all()
            left = places[_LEFT_HIP] - places[_RIGHT_HIP] if hips else None
            if left is not None and np.linalg.norm(left) < 1e-3:
                left = None
            self.rig = calibrated(self.rig, world, self._body, height=offsets[0, 1], left=left)
            return
        if self._is_new(frame.given, offsets) and not self._calibrated:
            still = np.tile(_IDENTITY, (N_JOINTS, 1))
            places = humanoid.CHAIN.world_positions(still, self._offsets)
            fresh = replace(Rig.of(range(N_JOINTS)), scale=self._scale(places))
            self.rig = fresh.aligned(places, still, self._seen, self._body)

    def _is_new(self, given: Bools, offsets: Array) -> bool:
        """Whether bones came that are not those of the model that is known.

        A bone that is missing, since its packet was lost, is where it was: the model is the same.
        """
        both = given & self._seen
        both[0] = False  # the hips move
        if (np.abs(offsets - self._offsets)[both] > _MOVED).any():  # another model
            self._offsets[:], self._seen[:] = 0.0, False
        new = given & ~self._seen
        self._offsets[new] = offsets[new]
        self._seen |= given
        return bool(new.any())

    def _scale(self, places: Array) -> float:
        """Our leg over the model's, from the pelvis down to the ankles; 1 if it has none."""
        theirs, ours = (at[0, 1] - at[_ANKLES, 1].mean() for at in (places, self._body.rest_joints))
        known = self._seen[_ANKLES].all() and HEIGHTS[0] < theirs < HEIGHTS[1]
        return float(ours / theirs) if known else 1.0

    def _device(self, address: str, serial: str, values: Array) -> None:
        if serial not in self.devices and len(self.devices) >= MAX_DEVICES:
            return
        self.devices[serial] = Device(
            _DEVICES[address],
            self.rig.axes @ unity.position(values[:3]),
            rot.multiply(
                rot.from_matrix(self.rig.axes), rot.normalize(unity.from_xyzw(values[3:7]))
            ),
            address.endswith("/Local"),
        )


class VmcEncoder:
    """Frames to packets: of a model that has a body's own proportions and no rotations at rest."""

    def __init__(self, person: str, body: Body) -> None:
        self._person, self._body = person, body
        self._rig = Rig.of(range(N_JOINTS))
        self._offsets = unity.position(humanoid.CHAIN.offsets(body.rest_joints))

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """See `Encoder.encode`. A person who has no pose yet is not sent, only that nobody is."""
        pose = outgoing.poses.get(self._person)
        begin = [
            Message(_OK, (int(pose is not None), 3, 0, int(pose is not None))),
            Message(_TIME, (float(outgoing.time),)),
        ]
        if pose is None:
            return osc.bundles(begin, MAX_PACKET)
        positions, quaternions = self._body.joint_frames(pose)
        local = humanoid.CHAIN.local_rotations(self._rig.bones(quaternions))
        places = self._offsets.copy()
        places[0] = unity.position(self._rig.places(positions[0]))
        rows = np.concatenate([places, unity.to_xyzw(local)], axis=1).tolist()
        begin.append(Message(_ROOT, ("root", *_REST)))
        bones = [
            Message(_BONE, (name, *row)) for name, row in zip(humanoid.BONES, rows, strict=True)
        ]
        return osc.bundles(begin + bones, MAX_PACKET)


def _checked(message: Message) -> Array | None:
    """The numbers of a message about a place; None of other messages.

    Raises:
        Malformed: Of the messages that are read, one has other arguments than it should.
    """
    address, arguments = message.address, message.arguments
    if address in (_BONE, _ROOT) or address in _DEVICES:
        if len(arguments) < 8 or not isinstance(arguments[0], str):
            raise Malformed(
                f"{address}: found {len(arguments)} arguments, expected a name, 7 numbers"
            )
        values = arguments[1:8]
        if not all(_is_number(value) and abs(value) < _FAR for value in values):
            raise Malformed(f"{address}: numbers that are not finite or far out of range")
        if sum(value * value for value in values[3:]) < 1e-6:
            raise Malformed(f"{address}: a quaternion of zeros")
        return np.array(values, dtype=np.float64)
    if address == _TIME and not (len(arguments) == 1 and _is_number(arguments[0])):
        raise Malformed(f"{address}: expected one finite number")
    if address == _OK and not (
        1 <= len(arguments) <= 8 and all(_is_number(value) for value in arguments)
    ):
        raise Malformed(f"{address}: expected 1 to 4 integers")
    return None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)
