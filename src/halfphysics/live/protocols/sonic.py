"""SONIC (NVIDIA GR00T-WholeBodyControl): corrected poses to a robot, as its own streamer sends.

A ZeroMQ publisher (port 5556) sends messages of one part: the topic ``pose``, a header of 1280
bytes (JSON, padded with zeros) that names fields, types and shapes, then their bytes,
little-endian. This is protocol 3, with the last `FRAMES` frames at 50 a second:

- ``smpl_pose`` (N, 21, 3): SMPL's body joints, axis-angle [rad];
- ``smpl_joints`` (N, 24, 3): places [m] of the 22 joints and the ends of the thumbs, seen from the
  pelvis, whose rotation is taken out;
- ``body_quat_w`` (N, 4): the pelvis's rotation in a z-up world, w, x, y, z, without SMPL's own at
  rest: no rotation is upright and looks along x;
- ``frame_index`` (N,), and ``joint_pos``, ``joint_vel`` (N, 29): the robot's joints, of which only
  the wrists (23 to 28) mean something.

Where the person is in the world is not sent. Layout: docs/source/tutorials/zmq.md and
gear_sonic/scripts/pico_manager_thread_server.py of that repository.
"""

from __future__ import annotations

import json
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.euler import to_angles
from halfphysics.base.optional_package import optional
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.live.incoming import Outgoing
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import BODY_JOINTS, JOINT_INDEX

Array = NDArray[np.float64]

#: Port of SONIC's publisher.
PORT = 5556
#: Frames a second, frames in a message, size of the header [bytes].
FPS, FRAMES, HEADER = 50, 5, 1280

_TOPIC = b"pose"
_PLACES = (*range(22), JOINT_INDEX["left_thumb3"], JOINT_INDEX["right_thumb3"])
# SMPL's axes at rest (y up, z ahead) in a z-up world that is looked along x.
_REST = np.array([0.5, 0.5, 0.5, 0.5])
_TYPES = {"f": "f32", "i": "i64"}
_SIDES = (("left", 1.0, (23, 25, 27)), ("right", -1.0, (24, 26, 28)))


def sender(endpoint: Endpoint, person: str, body: Body) -> SonicSender:
    """A publisher."""
    return SonicSender(endpoint, person, body)


def pack(fields: dict[str, NDArray[Any]], version: int = 3) -> bytes:
    """A message of arrays of float32 and int64."""
    described = [
        {"name": name, "dtype": _TYPES[array.dtype.kind], "shape": list(array.shape)}
        for name, array in fields.items()
    ]
    header = {"v": version, "endian": "le", "count": 1, "fields": described}
    text = json.dumps(header, separators=(",", ":")).encode()
    data = b"".join(
        array.astype(array.dtype.newbyteorder("<")).tobytes() for array in fields.values()
    )
    return _TOPIC + text.ljust(HEADER, b"\0") + data


@dataclass(frozen=True, eq=False)
class _Frame:
    """One frame of a message."""

    index: int
    pose: Array
    places: Array
    root: Array
    wrists: Array


class SonicEncoder:
    """Frames to messages, at SONIC's own rate: poses between two frames are interpolated."""

    def __init__(self, person: str, body: Body) -> None:
        self._person, self._body = person, body
        self._before: tuple[float, Pose] | None = None
        self._frames: deque[_Frame] = deque(maxlen=FRAMES)
        self._next = 0

    def encode(self, outgoing: Outgoing) -> list[bytes]:
        """See `Encoder.encode`: a message for each 50th of a second that has passed."""
        pose = outgoing.poses.get(self._person)
        if pose is None:
            return []
        before, now = self._before, outgoing.time
        self._before = now, pose
        if before is None or not 0.0 < now - before[0] < 1.0:  # a start, or a jump in time
            self._frames.clear()
            self._next = int(np.ceil(now * FPS - 1e-6))
            before = now, pose
        messages = []
        while self._next <= now * FPS + 1e-6:
            way = now - before[0]
            share = 1.0 if way == 0.0 else (self._next / FPS - before[0]) / way
            self._frames.append(self._frame(_between(before[1], pose, min(max(share, 0.0), 1.0))))
            self._next += 1
            if len(self._frames) == FRAMES:
                messages.append(pack(self._fields()))
        return messages

    def _frame(self, pose: Pose) -> _Frame:
        positions, quaternions = self._body.joint_frames(pose)
        root = rot.multiply(quaternions[0], rot.conjugate(_REST))
        places = rot.rotate(rot.conjugate(root), positions[list(_PLACES)] - positions[0])
        body = pose.rotations[list(BODY_JOINTS)]
        return _Frame(self._next, body, places, root, wrists(pose.rotations))

    def _fields(self) -> dict[str, NDArray[Any]]:
        frames = self._frames
        robot = np.stack([frame.wrists for frame in frames]).astype(np.float32)
        return {
            "smpl_pose": np.stack([frame.pose for frame in frames]).astype(np.float32),
            "smpl_joints": np.stack([frame.places for frame in frames]).astype(np.float32),
            "body_quat_w": rot.continuous([frame.root for frame in frames]).astype(np.float32),
            "joint_pos": robot,
            "joint_vel": np.zeros_like(robot),
            "frame_index": np.array([frame.index for frame in frames], dtype=np.int64),
        }


def wrists(rotations: Array) -> Array:
    """Joints of the robot (29,) [rad], of which only the wrists are set.

    As SONIC maps them: the forearm's turn out of the elbow's hinge, and the hand's turn, as angles
    about x, y, z.

    Args:
        rotations: Of the 55 joints (55, 3).
    """
    robot = np.zeros(29)
    for side, sign, (roll, pitch, yaw) in _SIDES:
        elbow = rot.exp(rotations[JOINT_INDEX[f"{side}_elbow"]])
        hand = rot.exp(rotations[JOINT_INDEX[f"{side}_wrist"]])
        bend = elbow * [1.0, 0.0, 1.0, 0.0]
        bend = rot.normalize(bend) if bend @ bend > 1e-12 else np.array([1.0, 0.0, 0.0, 0.0])
        swing = rot.multiply(elbow, rot.conjugate(bend))
        angles = to_angles((0, 1, 2), np.stack([swing, hand])[None])[0]
        robot[roll] = sign * (angles[0, 0] + angles[1, 0])
        robot[pitch] = sign * angles[1, 1]
        robot[yaw] = angles[0, 2] + angles[1, 2]
    return robot


def _between(a: Pose, b: Pose, share: float) -> Pose:
    turns = rot.slerp(rot.exp(a.rotations), rot.exp(b.rotations), np.array(share))
    place = a.translation + (b.translation - a.translation) * share
    return Pose(place, rot.log(turns), b.axes)


class SonicSender:
    """A `Sender` that publishes; who subscribes late gets the newest messages only."""

    def __init__(self, endpoint: Endpoint, person: str, body: Body) -> None:
        zmq = optional("zmq", "messages to SONIC", "sonic")
        self.endpoint = endpoint
        self.encoder = SonicEncoder(person, body)
        self.sent = self.dropped = 0
        self._again = zmq.Again
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.PUB)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.SNDHWM, 2 * FRAMES)
        self._flags = zmq.NOBLOCK
        try:
            self._socket.bind(f"tcp://{endpoint.host}:{endpoint.port or '*'}")
        except zmq.ZMQError as error:
            self.stop()
            raise InputError(
                f"{endpoint}: cannot publish there ({error}). Is another program using port "
                f"{endpoint.port}? End it, or choose another port"
            ) from None
        port = int(self._socket.getsockopt_string(zmq.LAST_ENDPOINT).rpartition(":")[2])
        self.endpoint = Endpoint(endpoint.protocol, endpoint.host, port)

    def send(self, outgoing: Outgoing) -> None:
        """Publish a frame's messages."""
        for data in self.encoder.encode(outgoing):
            try:
                self._socket.send(data, self._flags)
                self.sent += 1
            except self._again:
                self.dropped += 1

    def stop(self) -> None:
        """Close it."""
        self._socket.close()
        self._context.term()
