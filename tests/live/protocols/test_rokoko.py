"""Rokoko: the example of its documentation, the T-pose of its plug-in, loops, noise."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.rokoko import REST, RokokoDecoder, RokokoEncoder
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, furthest, outgoing, t_pose

#: Six decimals of a number: angles [degrees], places [m].
ANGLE, PLACE = 1e-3, 1e-5
KNOWN = sorted(JOINT_INDEX[joint] for joint, _ in REST.values())

#: As the support article "Custom streaming" prints it, cut short.
EXAMPLE = {
    "version": 3,
    "fps": 60,
    "scene": {
        "timestamp": 0.25,
        "actors": [
            {
                "name": "Dimitris",
                "meta": {"hasGloves": True, "hasBody": True, "hasFace": False},
                "dimensions": {"totalHeight": 180, "hipHeight": 100},
                "body": {
                    "hip": {
                        "position": {"x": 1.0, "y": 1.0, "z": 2.0},
                        "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
                    },
                },
            }
        ],
        "props": [],
    },
}


def with_body(**bones):
    message = json.loads(json.dumps(EXAMPLE))
    body = message["scene"]["actors"][0]["body"]
    for bone, turn in bones.items():
        body[bone] = {
            "position": dict.fromkeys("xyz", 0.0),
            "rotation": dict(zip("xyzw", turn, strict=True)),
        }
    return json.dumps(message).encode()


def test_the_documented_example():
    """y up, z ahead, x to the right; the person's legs are as long as ours afterwards."""
    (incoming,) = RokokoDecoder(PERSON, BODY).decode(json.dumps(EXAMPLE).encode(), 0.0)
    scale = BODY.rest_joints[0, 1] - BODY.rest_vertices[:, 1].min()
    assert np.allclose(BODY.joints(incoming.pose)[0], np.array([-1.0, -2.0, 1.0]) * scale)
    assert incoming.tracked.sum() == 1
    assert incoming.time == 0.25
    assert furthest(incoming.pose, t_pose()) < 1e-6


def test_the_plug_ins_t_pose_is_ours():
    """The quaternions of Rokoko's plug-in for Unity, with three digits as it has them."""
    theirs = {
        "leftUpLeg": (0.0, 0.707, 0.0, 0.707),
        "leftFoot": (0.0, 0.707, -0.707, 0.0),
        "rightFoot": (0.0, -0.707, 0.707, 0.0),
        "spine": (0.0, 0.0, 1.0, 0.0),
        "leftShoulder": (0.0, 0.0, 0.707, -0.707),
        "leftUpperArm": (-0.5, -0.5, 0.5, -0.5),
        "rightHand": (0.5, -0.5, 0.5, 0.5),
        "leftThumbProximal": (-0.56098, -0.70106, 0.43046, -0.0923),
        "rightThumbDistal": (0.65328, -0.65328, 0.2706, 0.2706),
        "leftLittleDistal": (-0.5, -0.5, 0.5, -0.5),
    }
    (incoming,) = RokokoDecoder(PERSON, BODY).decode(with_body(**theirs), 0.0)
    assert furthest(incoming.pose, t_pose()) < 0.05
    assert incoming.tracked.sum() == 1 + len(theirs)


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_a_loop_keeps_poses(seed):
    pose = any_pose(seed, joints=KNOWN)
    (data,) = RokokoEncoder(PERSON, BODY).encode(outgoing(pose, 3))
    (incoming,) = RokokoDecoder(PERSON, BODY).decode(data, 0.0)
    assert furthest(incoming.pose, pose) < ANGLE
    assert np.abs(incoming.pose.translation - pose.translation).max() < PLACE
    assert np.flatnonzero(incoming.tracked).tolist() == KNOWN
    assert incoming.time == 3 / 60


def test_what_is_written_has_the_documented_fields():
    (data,) = RokokoEncoder(PERSON, BODY).encode(outgoing(any_pose(1)))
    message = json.loads(data)
    assert (message["version"], message["fps"]) == (3, 60)
    (actor,) = message["scene"]["actors"]
    assert set(EXAMPLE["scene"]["actors"][0]) <= set(actor)
    assert set(actor["body"]["hip"]) == {"position", "rotation"}
    assert len(data) < 65_507
    (nobody,) = RokokoEncoder(PERSON, BODY).encode(outgoing(None))
    assert json.loads(nobody)["scene"]["actors"] == []
    assert RokokoDecoder(PERSON, BODY).decode(nobody, 0.0) == []


def test_a_t_pose_calibrates():
    decoder = RokokoDecoder(PERSON, BODY)
    decoder.calibrate()
    data = with_body(leftUpperArm=(0.1, 0.2, 0.3, 0.9), spine=(0.5, 0.5, 0.5, 0.5))
    (incoming,) = decoder.decode(data, 0.0)
    assert furthest(incoming.pose, t_pose()) < 1e-4
    (incoming,) = decoder.decode(data, 0.0)
    assert furthest(incoming.pose, t_pose()) < 1e-4


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x04\x22\x4d\x18compressed",
        b"[" * 60_000,
        b"9" * 60_000,
        b"null",
        b'{"version": 2, "scene": {"actors": []}}',
        b'{"version": 3}',
        b'{"version": 3, "scene": {"actors": 7}}',
        b'{"version": 3, "scene": {"actors": [7]}}',
        with_body(spine=(0, 0, 0, 0)),
        with_body(spine=(float("nan"), 0, 0, 1)),
        with_body(spine=(float("inf"), 0, 0, 1)),
        with_body(spine=("1", 0, 0, 1)),
        with_body().replace(b'"hip": {', b'"head": 3, "hip": {'),
    ],
)
def test_what_is_no_message_is_refused(data):
    with pytest.raises(Malformed):
        RokokoDecoder(PERSON, BODY).decode(data, 0.0)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=3),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(
                ["actors", "body", "hip", "position", "rotation", "x", "y", "z", "w", "dimensions"]
            ),
            inner,
            max_size=5,
        )
    ),
    max_leaves=12,
)


@settings(max_examples=200)
@given(JSON, JSON, st.binary(max_size=40))
def test_noise_is_read_or_refused(scene, hip, noise):
    actors = [{"body": {"hip": hip}, "dimensions": scene}]
    for data in (
        noise,
        json.dumps({"version": 3, "scene": scene}).encode(),
        json.dumps({"version": 3, "scene": {"actors": actors, "timestamp": hip}}).encode(),
    ):
        try:
            for incoming in RokokoDecoder(PERSON, BODY).decode(data, 0.0):
                assert np.isfinite(incoming.pose.rotations).all()
        except Malformed:
            pass
