"""Xsens: datagrams packed from the specification, loops, split samples, units, noise."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.xsens import (
    JOINTS,
    N_BODY,
    SEGMENTS,
    XsensDecoder,
    XsensEncoder,
    header,
)
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, furthest, outgoing, t_pose

#: Numbers of single precision: angles [degrees], places [m].
ANGLE, PLACE = 1e-4, 1e-5
HALF = 0.5**0.5
#: Joints that MVN has a segment for.
KNOWN = sorted(set(JOINTS))
PELVIS_HEIGHT = BODY.rest_joints[0, 1] - BODY.rest_vertices[:, 1].min()


def datagram(items, *, sample=1, part=0x80, character=0, props=0, kind=b"02", time=1234):
    """6 s ID, u32 sample, u8 part, u8 items, u32 time, u8 character, 3 counts, 2 reserved, size."""
    payload = b"".join(struct.pack(">I7f", *item) for item in items)
    return (
        b"MXTP"
        + kind
        + struct.pack(">IBBI", sample, part, len(items), time)
        + struct.pack(">BBBB", character, 23, props, 0)
        + bytes(2)
        + struct.pack(">H", len(payload))
        + payload
    )


def standing(unit=1.0, rotations=None, at=(0.0, 0.0)):
    """23 segments of a person of round numbers who looks along x."""
    rotations = rotations or {}
    height = {name: 0.9 + 0.1 * i for i, name in enumerate(SEGMENTS[:7])}
    return [
        (
            i,
            *np.array([*at, height.get(name, 0.5)]) * unit,
            *rotations.get(name, (1.0, 0.0, 0.0, 0.0)),
        )
        for i, name in enumerate(SEGMENTS, 1)
    ]


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_a_person_in_xsens_axes(unit):
    """No rotations: a T-pose along x. The right forearm bends forward: a quarter about z."""
    turns = {"Right Forearm": (HALF, 0.0, 0.0, HALF), "Right Hand": (HALF, 0.0, 0.0, HALF)}
    (incoming,) = XsensDecoder(PERSON, BODY).decode(
        datagram(standing(unit, turns, at=(2.0, 1.0))), 0.0
    )
    assert incoming.time == 1.234
    positions = BODY.joints(incoming.pose)
    assert np.allclose(positions[0], [2.0, 1.0, 0.9], atol=PLACE)
    left = positions[JOINT_INDEX["left_hip"]] - positions[JOINT_INDEX["right_hip"]]
    assert np.allclose(left / np.linalg.norm(left), [0.0, 1.0, 0.0], atol=0.05)
    fore = positions[JOINT_INDEX["right_wrist"]] - positions[JOINT_INDEX["right_elbow"]]
    assert fore[0] / np.linalg.norm(fore) > 0.99
    assert np.flatnonzero(incoming.tracked).tolist() == sorted(set(JOINTS[:N_BODY]))


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_a_loop_keeps_poses(seed):
    """With fingers, in two datagrams a frame; L5 and L3 are one joint of ours."""
    pose = any_pose(seed, joints=KNOWN)
    encoder, decoder = XsensEncoder(PERSON, BODY), XsensDecoder(PERSON, BODY)
    packets = encoder.encode(outgoing(pose))
    assert max(map(len, packets)) <= 1500
    poses = [p for packet in packets for p in decoder.decode(packet, 0.0)]
    assert furthest(poses[-1].pose, pose, KNOWN) < ANGLE
    assert np.abs(poses[-1].pose.translation - pose.translation).max() < PLACE


def test_what_is_written_follows_the_specification():
    skeleton, body, hands = XsensEncoder(PERSON, BODY).encode(outgoing(t_pose((1.0, 2.0)), 9))
    assert (header(skeleton).kind, header(body).kind) == (b"13", b"02")
    assert len(body) == 760 == 24 + 23 * 32
    assert body[:6] == b"MXTP02"
    assert struct.unpack(">IBBI", body[6:16]) == (9, 0x00, 23, 150)
    assert body[16:20] == bytes([0, 23, 0, 40])
    assert struct.unpack(">H", body[22:24]) == (23 * 32,)
    assert hands[10] == 0x81
    number, *pelvis = struct.unpack(">I7f", body[24:56])
    assert number == 1
    # It looks along -y: a quarter turn to the right.
    assert np.allclose(pelvis, [1.0, 2.0, PELVIS_HEIGHT, HALF, 0.0, 0.0, -HALF], atol=PLACE)


def test_a_sample_in_parts_is_complete_with_the_last_one():
    items = standing()
    decoder = XsensDecoder(PERSON, BODY)
    assert decoder.decode(datagram(items[:10], part=0), 0.0) == []
    (incoming,) = decoder.decode(datagram(items[10:], part=0x81), 0.0)
    assert incoming.tracked.sum() == 22
    # Of the next sample only the second half comes: nothing is left over from this one.
    assert decoder.decode(datagram(items[10:], sample=2, part=0x81), 0.0) == []


def test_props_are_passed_over_and_hands_found_behind_them():
    turn = (HALF, HALF, 0.0, 0.0)
    items = [*standing(), (24, 1, 1, 1, *turn), (24 + 1 + 2, 0, 0, 0, *turn)]
    (incoming,) = XsensDecoder(PERSON, BODY).decode(datagram(items, props=1), 0.0)
    fingers = [j for j in np.flatnonzero(incoming.tracked) if j >= 25]
    assert fingers == [JOINT_INDEX["left_thumb2"]]


def test_a_segment_of_number_0_is_none():
    """Numbers are from 1; a 0 is not the last finger."""
    rows = [*standing(), (0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0)]
    (found,) = XsensDecoder(PERSON, BODY).decode(datagram(rows), 0.0)
    assert not found.tracked[JOINTS[-1]]


def test_one_character_is_taken():
    decoder = XsensDecoder(PERSON, BODY)
    assert decoder.decode(datagram(standing(), character=3), 0.0)
    assert decoder.decode(datagram(standing(), character=4, sample=2), 0.0) == []
    assert decoder.decode(datagram(standing(), character=3, sample=3), 0.0)


def test_the_places_at_rest_give_the_scale():
    """The sender's pelvis is at 0.6 m: what it goes is stretched to our legs."""
    entries = [("Pelvis", 0.6), ("Left Foot", 0.1), ("Head", 1.2)]
    payload = struct.pack(">I", len(entries))
    for name, height in entries:
        payload += struct.pack(">i", len(name)) + name.encode()
        payload += struct.pack(">3f", 0.0, 0.0, height)
    payload += struct.pack(">I", 0)
    decoder = XsensDecoder(PERSON, BODY)
    head = datagram([], kind=b"13")[:22]
    assert decoder.decode(head + struct.pack(">H", len(payload)) + payload, 0.0) == []
    (incoming,) = decoder.decode(datagram(standing(at=(1.0, 0.0))), 0.0)
    scale = PELVIS_HEIGHT / 0.6
    assert np.allclose(BODY.joints(incoming.pose)[0], [scale, 0.0, 0.9 * scale], atol=PLACE)


def test_a_t_pose_calibrates():
    """Segments that are askew, of a person who looks elsewhere."""
    askew = {"Pelvis": (0.9, 0.1, 0.2, 0.3), "T8": (0.8, 0.1, -0.2, 0.4), "Head": (0, 0, 0, 1)}
    decoder = XsensDecoder(PERSON, BODY)
    decoder.calibrate()
    (incoming,) = decoder.decode(datagram(standing(rotations=askew)), 0.0)
    joints = [j for j in range(55) if j]
    assert furthest(incoming.pose, t_pose(), joints) < 1e-3


def test_other_messages_are_passed_over():
    assert XsensDecoder(PERSON, BODY).decode(datagram([], kind=b"25"), 0.0) == []


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"MXTP02",
        b"JUNK02" + bytes(18),
        datagram(standing())[:-1],
        datagram([(1, np.nan, 0, 0, 1, 0, 0, 0)]),
        datagram([(1, 1e9, 0, 0, 1, 0, 0, 0)]),
        datagram([(1, 0, 0, 0, 0, 0, 0, 0)]),
        datagram([], kind=b"13")[:24],
        datagram([], kind=b"13") + struct.pack(">Ii", 1, 99) + b"Pelvis",
        datagram([], kind=b"13") + struct.pack(">Ii3f", 1, 0, np.inf, 0, 0),
    ],
)
def test_what_is_no_datagram_is_refused(data):
    with pytest.raises(Malformed):
        XsensDecoder(PERSON, BODY).decode(data, 0.0)


@settings(max_examples=200)
@given(st.integers(0, 800), st.binary(max_size=40), st.integers(0, 2))
def test_noise_is_read_or_refused(at, noise, which):
    packet = XsensEncoder(PERSON, BODY).encode(outgoing(t_pose()))[which]
    decoder = XsensDecoder(PERSON, BODY)
    for data in (noise, packet[:at], packet[:at] + noise + packet[at + len(noise) :]):
        try:
            for incoming in decoder.decode(data, 0.0):
                assert np.isfinite(incoming.pose.rotations).all()
        except Malformed:
            pass
