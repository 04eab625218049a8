"""SONIC: messages as its documentation has them, its own arithmetic as oracle, and ZeroMQ."""

from __future__ import annotations

import contextlib
import json
import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from halfphysics.errors import InputError
from halfphysics.live.protocols import sonic
from halfphysics.live.protocols.endpoint import Endpoint
from halfphysics.live.protocols.sonic import FRAMES, HEADER, SonicEncoder
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, outgoing, t_pose

#: Numbers of single precision.
NEAR = 1e-5


def unpacked(message):
    """Fields of a message, read as the document says."""
    assert message.startswith(b"pose")
    header = json.loads(message[4 : 4 + HEADER].rstrip(b"\0"))
    assert (header["v"], header["endian"]) == (3, "le")
    at, fields = 4 + HEADER, {}
    for entry in header["fields"]:
        kind = {"f32": "<f4", "i64": "<i8"}[entry["dtype"]]
        count = int(np.prod(entry["shape"]))
        array = np.frombuffer(message, kind, count, at).reshape(entry["shape"])
        fields[entry["name"]], at = array, at + array.nbytes
    assert at == len(message)
    return fields


def messages(poses, fps=50.0):
    from dataclasses import replace

    encoder = SonicEncoder(PERSON, BODY)
    out = []
    for k, pose in enumerate(poses):
        out += encoder.encode(replace(outgoing(pose, k), time=k / fps))
    return [unpacked(message) for message in out]


def test_fields_shapes_and_numbers():
    found = messages([any_pose(1)] * (FRAMES + 2))
    assert len(found) == 3
    shapes = {name: (array.shape, array.dtype.str) for name, array in found[0].items()}
    assert shapes == {
        "smpl_pose": ((5, 21, 3), "<f4"),
        "smpl_joints": ((5, 24, 3), "<f4"),
        "body_quat_w": ((5, 4), "<f4"),
        "joint_pos": ((5, 29), "<f4"),
        "joint_vel": ((5, 29), "<f4"),
        "frame_index": ((5,), "<i8"),
    }
    assert [fields["frame_index"].tolist() for fields in found] == [
        [0, 1, 2, 3, 4],
        [1, 2, 3, 4, 5],
        [2, 3, 4, 5, 6],
    ]


def test_the_arithmetic_of_their_streamer():
    """With scipy: the root upright without SMPL's base, joints seen from it, wrists by angles."""
    pose = any_pose(2)
    fields = {name: array[-1] for name, array in messages([pose] * FRAMES)[-1].items()}
    turns = pose.rotations.copy()
    root = Rotation.from_rotvec(turns[0])
    base = Rotation.from_quat([0.5, 0.5, 0.5, 0.5])
    expected = root * base.inv()
    sent = Rotation.from_quat(fields["body_quat_w"][[1, 2, 3, 0]])
    assert (sent.inv() * expected).magnitude() < NEAR
    places = BODY.joints(pose)[[*range(22), 39, 54]]
    assert np.allclose(fields["smpl_joints"], expected.inv().apply(places - places[0]), atol=NEAR)
    assert np.allclose(fields["smpl_pose"], pose.rotations[1:22], atol=NEAR)
    for side, sign, (roll, pitch, yaw) in (("left", 1, (23, 25, 27)), ("right", -1, (24, 26, 28))):
        elbow = Rotation.from_rotvec(turns[JOINT_INDEX[f"{side}_elbow"]])
        _x, y, _z, w = elbow.as_quat()
        swing = elbow * Rotation.from_quat([0.0, y, 0.0, w]).inv()
        bend = swing.as_euler("XYZ")
        hand = Rotation.from_rotvec(turns[JOINT_INDEX[f"{side}_wrist"]]).as_euler("XYZ")
        wanted = {roll: sign * (bend[0] + hand[0]), pitch: sign * hand[1], yaw: bend[2] + hand[2]}
        for joint, angle in wanted.items():
            assert fields["joint_pos"][joint] == pytest.approx(angle, abs=NEAR)
    assert not fields["joint_pos"][:23].any()


def test_upright_along_x_is_no_rotation():
    pose = t_pose()
    rotations = pose.rotations.copy()
    turn = Rotation.from_euler("z", 90, degrees=True) * Rotation.from_rotvec(rotations[0])
    rotations[0] = turn.as_rotvec()
    fields = messages([type(pose)(pose.translation, rotations)] * FRAMES)[-1]
    assert np.allclose(np.abs(fields["body_quat_w"]), [1.0, 0.0, 0.0, 0.0], atol=NEAR)
    assert fields["smpl_joints"][-1, JOINT_INDEX["left_wrist"], 1] > 0.4  # left is y


def test_other_rates_become_fifty():
    """Poses at 30 and 90 a second: frames at their own times, between those that came."""
    ways = np.linspace(0.0, 0.5, 91)
    for fps, step in ((90.0, 1), (30.0, 3)):
        poses = []
        for share in ways[::step]:
            rotations = t_pose().rotations.copy()
            rotations[JOINT_INDEX["left_elbow"]] = [0.0, -share, 0.0]
            poses.append(type(t_pose())(t_pose().translation, rotations))
        found = messages(poses, fps)
        index = [int(fields["frame_index"][-1]) for fields in found]
        assert index == list(range(4, 51))
        bends = [fields["smpl_pose"][-1, JOINT_INDEX["left_elbow"] - 1, 1] for fields in found]
        assert np.allclose(bends, [-0.5 * k / 50 for k in index], atol=1e-4)


def test_nobody_and_jumps_in_time():
    from dataclasses import replace

    encoder = SonicEncoder(PERSON, BODY)
    assert encoder.encode(outgoing(None)) == []
    frame = outgoing(t_pose())
    assert len([m for k in range(8) for m in encoder.encode(replace(frame, time=k / 50))]) == 4
    assert encoder.encode(replace(frame, time=100.0)) == []
    assert encoder.encode(replace(frame, time=3.0)) == []


def test_a_subscriber_gets_the_messages():
    import zmq

    sender = sonic.sender(Endpoint("sonic", "127.0.0.1", 0), PERSON, BODY)
    context = zmq.Context()
    subscriber = context.socket(zmq.SUB)
    subscriber.setsockopt(zmq.SUBSCRIBE, b"pose")
    subscriber.setsockopt(zmq.RCVTIMEO, 20)
    subscriber.connect(f"tcp://127.0.0.1:{sender.endpoint.port}")
    end, got = time.monotonic() + 30.0, None
    k = 0
    while got is None and time.monotonic() < end:
        frame = outgoing(any_pose(3), 0)
        sender.send(type(frame)(**{**vars(frame), "time": k / 50}))
        k += 1
        with contextlib.suppress(zmq.Again):
            got = subscriber.recv()
    with pytest.raises(InputError, match="cannot publish"):
        sonic.sender(sender.endpoint, PERSON, BODY)
    subscriber.close()
    context.term()
    sender.stop()
    assert np.allclose(unpacked(got)["smpl_pose"][-1], any_pose(3).rotations[1:22], atol=NEAR)
