"""mocopi: packets written from the description of its fields, loops, calibration, noise."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.mocopi import (
    JOINTS,
    PARENTS,
    SKELETON_EVERY,
    MocopiDecoder,
    MocopiEncoder,
    fields,
)
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, furthest, outgoing, t_pose

#: Numbers of single precision: angles [degrees], places [m].
ANGLE, PLACE = 1e-4, 1e-5
HALF = 0.5**0.5
IDENTITY = (0.0, 0.0, 0.0, 1.0)
#: A person of round numbers: from the parent [m], x left, y up, z ahead.
REST = {
    0: (0.0, 0.9, 0.0),
    **{i: (0.0, 0.06, 0.0) for i in range(1, 11)},
    **{11: (0.05, 0.05, 0.0), 12: (0.15, 0.0, 0.0), 13: (0.3, 0.0, 0.0), 14: (0.25, 0.0, 0.0)},
    **{15: (-0.05, 0.05, 0.0), 16: (-0.15, 0.0, 0.0), 17: (-0.3, 0.0, 0.0), 18: (-0.25, 0.0, 0.0)},
    **{19: (0.1, 0.0, 0.0), 20: (0.0, -0.4, 0.0), 21: (0.0, -0.42, 0.0), 22: (0.0, -0.08, 0.13)},
    **{23: (-0.1, 0.0, 0.0), 24: (0.0, -0.4, 0.0), 25: (0.0, -0.42, 0.0), 26: (0.0, -0.08, 0.13)},
}


def tlv(name, value):
    return struct.pack("<I", len(value)) + name + value


HEAD = tlv(b"head", tlv(b"ftyp", b"sony motion format") + tlv(b"vrsn", b"\x01"))
SENDER = tlv(b"sndf", tlv(b"ipad", bytes(8)) + tlv(b"rcvp", struct.pack("<H", 12351)))


def skeleton():
    bones = b"".join(
        tlv(
            b"bndt",
            tlv(b"bnid", struct.pack("<H", i))
            + tlv(b"pbid", struct.pack("<h", PARENTS[i]))
            + tlv(b"tran", struct.pack("<7f", *IDENTITY, *REST[i])),
        )
        for i in range(27)
    )
    return HEAD + SENDER + tlv(b"skdf", tlv(b"bons", bones))


def frame(rotations=None, root=REST[0], bones=range(27), seconds=1.5):
    rotations = rotations or {}
    records = b"".join(
        tlv(
            b"btdt",
            tlv(b"bnid", struct.pack("<H", i))
            + tlv(
                b"tran", struct.pack("<7f", *rotations.get(i, IDENTITY), *REST[i] if i else root)
            ),
        )
        for i in bones
    )
    return (
        HEAD
        + SENDER
        + tlv(
            b"fram",
            tlv(b"fnum", struct.pack("<I", 7))
            + tlv(b"time", struct.pack("<f", seconds))
            + tlv(b"uttm", struct.pack("<d", 1.7e9))
            + tlv(b"tmcd", bytes(6))
            + tlv(b"btrs", records),
        )
    )


def test_lowered_arms_of_a_person_who_went_ahead():
    """The left arm, along x, is lowered by a quarter turn about -z; the right one about z."""
    decoder = MocopiDecoder(PERSON, BODY)
    assert decoder.decode(skeleton(), 0.0) == []
    arms = {12: (0.0, 0.0, -HALF, HALF), 16: (0.0, 0.0, HALF, HALF)}
    (incoming,) = decoder.decode(frame(arms, root=(0.0, 0.9, 2.0)), 0.0)
    positions = BODY.joints(incoming.pose)
    height = BODY.rest_joints[0, 1] - BODY.rest_vertices[:, 1].min()
    # Ours is as tall as the body: its pelvis is at its own height, and it goes as far in legs.
    assert np.allclose(positions[0], [0.0, -2.0 * height / 0.9, height], atol=PLACE)
    for side in ("left", "right"):
        down = positions[JOINT_INDEX[f"{side}_elbow"]] - positions[JOINT_INDEX[f"{side}_shoulder"]]
        assert np.allclose(down / np.linalg.norm(down), [0.0, 0.0, -1.0], atol=1e-6)
    assert incoming.time == 1.5
    assert set(np.flatnonzero(incoming.tracked)) == set(JOINTS)


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_a_loop_keeps_poses(seed):
    pose = any_pose(seed, joints=sorted(set(JOINTS)))
    encoder, decoder = MocopiEncoder(PERSON, BODY), MocopiDecoder(PERSON, BODY)
    poses = [p for packet in encoder.encode(outgoing(pose)) for p in decoder.decode(packet, 0.0)]
    assert furthest(poses[-1].pose, pose) < ANGLE
    assert np.abs(poses[-1].pose.translation - pose.translation).max() < PLACE


def test_what_is_written_follows_the_description():
    encoder = MocopiEncoder(PERSON, BODY)
    packets = encoder.encode(outgoing(any_pose(1), 5))
    names = [[name for name, _ in fields(packet)] for packet in packets]
    assert names == [[b"head", b"sndf", b"skdf"], [b"head", b"sndf", b"fram"]]
    assert packets[1].startswith(HEAD + SENDER)
    frame_fields = dict(fields(dict(fields(packets[1]))[b"fram"]))
    assert {name: len(value) for name, value in frame_fields.items() if name != b"btrs"} == {
        **{b"fnum": 4, b"time": 4},
        **{b"uttm": 8, b"tmcd": 6},
    }
    records = fields(frame_fields[b"btrs"])
    assert [name for name, _ in records] == [b"btdt"] * 27
    bones = fields(dict(fields(dict(fields(packets[0]))[b"skdf"]))[b"bons"])
    parents = [struct.unpack("<h", dict(fields(value))[b"pbid"])[0] for _, value in bones]
    assert tuple(parents) == PARENTS
    assert encoder.encode(outgoing(None)) == []


def test_the_skeleton_comes_again_for_late_receivers():
    encoder = MocopiEncoder(PERSON, BODY)
    counts = [len(encoder.encode(outgoing(t_pose(), k))) for k in range(2 * SKELETON_EVERY)]
    assert [k for k, count in enumerate(counts) if count == 2] == [0, SKELETON_EVERY]


def test_a_t_pose_that_leans_is_taken_as_upright():
    """Sensors that sit askew: what the person does from then on is right."""
    tilt = rot.exp([0.2, 0.0, 0.1])
    w, x, y, z = tilt
    decoder = MocopiDecoder(PERSON, BODY)
    decoder.decode(skeleton(), 0.0)
    decoder.calibrate()
    (incoming,) = decoder.decode(frame({3: (x, y, z, w)}), 0.0)
    assert furthest(incoming.pose, t_pose()) < 1e-3


def test_bones_that_are_lost_are_not_tracked():
    bad = {13: (np.nan, 0.0, 0.0, 1.0), 14: (0.0, 0.0, 0.0, 0.0)}
    (incoming,) = MocopiDecoder(PERSON, BODY).decode(frame(bad), 0.0)
    lost = [JOINT_INDEX["left_elbow"], JOINT_INDEX["left_wrist"]]
    assert not incoming.tracked[lost].any()
    assert incoming.tracked[JOINT_INDEX["left_shoulder"]]
    assert MocopiDecoder(PERSON, BODY).decode(frame(bones=range(1, 27)), 0.0) == []


@pytest.mark.parametrize(
    "data",
    [
        b"",
        bytes(4),
        struct.pack("<I", 4096) + b"fram" + bytes(16),
        HEAD + b"\x01\x02\x03",
        b"/VMC/Ext/T\x00\x00,f\x00\x00\x3f\x80\x00\x00",
        HEAD + SENDER,
        SENDER + tlv(b"fram", b""),
        tlv(b"head", tlv(b"ftyp", b"another format")) + tlv(b"fram", b""),
        HEAD + tlv(b"fram", tlv(b"time", bytes(2)) + tlv(b"btrs", b"")),
        frame(seconds=np.nan),
        HEAD + tlv(b"fram", tlv(b"time", bytes(4)) + tlv(b"btrs", tlv(b"btdt", b"12"))),
        HEAD + tlv(b"fram", tlv(b"time", bytes(4)) + tlv(b"btrs", tlv(b"btdt", tlv(b"bnid", b"")))),
    ],
)
def test_what_is_no_packet_is_refused(data):
    with pytest.raises(Malformed):
        MocopiDecoder(PERSON, BODY).decode(data, 0.0)


@settings(max_examples=200)
@given(st.integers(0, 2000), st.binary(max_size=20), st.booleans())
def test_noise_is_read_or_refused(at, noise, still):
    decoder = MocopiDecoder(PERSON, BODY)
    packet = skeleton() if still else frame()
    for data in (noise, packet[:at], packet[:at] + noise + packet[at + len(noise) :]):
        try:
            for incoming in decoder.decode(data, 0.0):
                assert np.isfinite(incoming.pose.rotations).all()
        except Malformed:
            pass


def test_frames_are_of_the_same_bytes():
    out = replace(outgoing(any_pose(2), 3), clock=5.0)
    assert MocopiEncoder(PERSON, BODY).encode(out) == MocopiEncoder(PERSON, BODY).encode(out)
