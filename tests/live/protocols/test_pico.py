"""PICO: arrays as the SDK gives them, by a module that stands for the SDK."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from halfphysics.base import rotations as rot
from halfphysics.errors import MissingDependencyError
from halfphysics.live.protocols import pico
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.pico import N_READ, PicoDecoder, PicoReceiver
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, furthest, t_pose

ANGLE = 1e-5


def array_of(pose):
    """(24, 7) of a pose, as SONIC reads it backwards: y up, each turned by half a turn about y."""
    positions, quaternions = BODY.joint_frames(pose)
    upright = rot.exp([-np.pi / 2, 0.0, 0.0])
    places = rot.rotate(upright, positions[:22])
    turns = rot.multiply(rot.multiply(upright, quaternions[:22]), rot.exp([0.0, -np.pi, 0.0]))
    rows = np.concatenate([places, turns[:, [1, 2, 3, 0]]], axis=1)
    return np.concatenate([rows, rows[20:22]])


def test_no_rotations_are_a_t_pose_that_looks_along_minus_z():
    rows = np.zeros((24, 7))
    rows[:, 6] = 1.0
    rows[0, :3] = [0.3, 0.9, -2.0]
    incoming = PicoDecoder(PERSON, BODY).decode(rows, 1.0)
    positions, quaternions = BODY.joint_frames(incoming.pose)
    # y up, -z ahead, x to the right becomes z up, y ahead, x to the right.
    assert np.allclose(positions[0], [0.3, 2.0, 0.9])
    assert np.allclose(rot.rotate(quaternions[0], [0.0, 0.0, 1.0]), [0.0, 1.0, 0.0])
    assert positions[JOINT_INDEX["left_wrist"], 0] < 0.0 < positions[JOINT_INDEX["right_wrist"], 0]
    assert furthest(incoming.pose, t_pose(), range(1, 55)) < ANGLE
    assert incoming.tracked.sum() == N_READ


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_poses_are_read(seed):
    pose = any_pose(seed, joints=range(N_READ))
    incoming = PicoDecoder(PERSON, BODY).decode(array_of(pose), 0.0)
    assert furthest(incoming.pose, pose) < ANGLE
    assert np.allclose(incoming.pose.translation, pose.translation)


def test_a_t_pose_calibrates():
    rows = array_of(any_pose(3, joints=range(N_READ), spread=0.1))
    decoder = PicoDecoder(PERSON, BODY)
    decoder.calibrate()
    incoming = decoder.decode(rows, 0.0)
    assert furthest(incoming.pose, t_pose(), range(1, 55)) < ANGLE


@settings(max_examples=100)
@given(
    arrays(np.float64, array_shapes(max_dims=3, max_side=8))
    | arrays(np.float64, (24, 7))
    | st.lists(st.text(max_size=2), max_size=3)
    | st.none()
)
def test_noise_is_read_or_refused(joints):
    try:
        pose = PicoDecoder(PERSON, BODY).decode(joints, 0.0).pose
    except Malformed:
        return
    assert np.isfinite(pose.rotations).all()


class Sdk:
    """Stands for xrobotoolkit_sdk: three frames, one of them twice, one of them broken."""

    def __init__(self, frames):
        self.frames, self.at, self.calls = frames, 0, []

    def init(self):
        self.calls.append("init")

    def close(self):
        self.calls.append("close")

    def is_body_data_available(self):
        self.at = min(self.at + 1, 2 * len(self.frames))
        return self.at > 1

    def get_time_stamp_ns(self):
        return (self.at - 1) // 2

    def get_body_joints_pose(self):
        return self.frames[min((self.at - 1) // 2, len(self.frames) - 1)].tolist()


def test_the_sdk_is_asked_in_a_thread():
    pose, poses = any_pose(5, joints=range(N_READ)), []
    frames = [array_of(pose), np.full((24, 7), np.nan), array_of(pose)]
    sdk = Sdk(frames)
    receiver = PicoReceiver(PERSON, BODY, sdk=sdk)
    receiver.start(poses.append)
    end = time.monotonic() + 30.0
    while len(poses) < 2 and time.monotonic() < end:
        time.sleep(0.005)
    receiver.stop()
    assert [p.time for p in poses] == [0.0, 2e-9]
    assert receiver.counts.malformed == 1
    assert sdk.calls == ["init", "close"]
    assert furthest(poses[-1].pose, pose) < ANGLE


def test_without_the_sdk_it_is_said():
    receiver = pico.receiver(None, PERSON, BODY)
    with pytest.raises(MissingDependencyError, match="xrobotoolkit_sdk"):
        receiver.start(lambda pose: None)
