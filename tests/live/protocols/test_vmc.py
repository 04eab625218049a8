"""VMC: packets written from its documentation, python-osc as oracle, loops, calibration, noise."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.live.protocols import humanoid, osc
from halfphysics.live.protocols.malformed import Malformed
from halfphysics.live.protocols.osc import Message
from halfphysics.live.protocols.vmc import MAX_DEVICES, MAX_PACKET, VmcDecoder, VmcEncoder
from halfphysics.motion.skeleton import JOINT_INDEX
from support.live_frames import BODY, PERSON, any_pose, furthest, outgoing, t_pose

#: Numbers of single precision: angles [degrees], places [m].
ANGLE, PLACE = 1e-4, 1e-5
HALF = 0.5**0.5


def padded(text: str) -> bytes:
    data = text.encode() + b"\0"
    return data + b"\0" * (-len(data) % 4)


def place(address: str, name: str, *values: float) -> bytes:
    """``(string){name} (float){p.x} ... (float){q.w}``, straight from the document."""
    return padded(address) + padded(",sfffffff") + padded(name) + struct.pack(">7f", *values)


def bone(name: str, *values: float) -> bytes:
    return place("/VMC/Ext/Bone/Pos", name, *values)


def decoded(decoder, packets):
    return [pose for packet in packets for pose in decoder.decode(packet, 0.0)]


def sent(pose, frame=0):
    return VmcEncoder(PERSON, BODY).encode(outgoing(pose, frame))


def looped(pose):
    """A pose that was sent twice and received: the first frame shows which bones there are."""
    return decoded(VmcDecoder(PERSON, BODY), sent(pose) + sent(pose, 1))[-1]


def test_a_person_in_unitys_axes():
    """Unity: x right, y up, z ahead; rotations are clockwise seen against their axis.

    The left arm, along -x, is lowered by a quarter turn about z; the person has turned to the
    right by a quarter, about y, and stands 2 m to the right.
    """
    frame = [
        bone("Hips", 2.0, 0.9, 0.0, 0.0, HALF, 0.0, HALF),
        bone("LeftUpperArm", 0.0, 0.0, 0.0, 0.0, 0.0, HALF, HALF),
    ]
    (first, second) = decoded(VmcDecoder(PERSON, BODY), frame * 2)
    for incoming in (first, second):
        positions, quaternions = BODY.joint_frames(incoming.pose)
        # The world's z is Unity's y; ahead is -y, left is x.
        assert np.allclose(positions[0], [-2.0, 0.0, 0.9], atol=PLACE)
        ahead = rot.rotate(quaternions[0], [0.0, 0.0, 1.0])
        assert np.allclose(ahead, [-1.0, 0.0, 0.0], atol=1e-6)
        arm = rot.rotate(quaternions[JOINT_INDEX["left_elbow"]], [1.0, 0.0, 0.0])
        assert np.allclose(arm, [0.0, 0.0, -1.0], atol=1e-6)
        assert np.flatnonzero(incoming.tracked).tolist() == [0, JOINT_INDEX["left_shoulder"]]
    assert first.person == PERSON


def test_every_bone_of_unity_is_a_joint():
    assert len(humanoid.BONES) == 55
    sides = [name.replace("Left", "Right") for name in humanoid.BONES if name.startswith("Left")]
    assert sorted(sides) == sorted(n for n in humanoid.BONES if n.startswith("Right"))


@given(st.integers(0, 10_000))
@settings(max_examples=30)
def test_a_loop_keeps_poses(seed):
    """All 55 joints, the place too: fingers, toes, eyes and jaw."""
    pose = any_pose(seed)
    got = looped(pose)
    assert furthest(pose, got.pose) < ANGLE
    assert np.abs(pose.translation - got.pose.translation).max() < PLACE
    assert got.tracked.all()


def test_an_independent_implementation_reads_the_packets():
    from pythonosc.osc_packet import OscPacket

    pose = any_pose(3)
    packets = sent(pose)
    assert max(map(len, packets)) <= MAX_PACKET
    messages = [timed.message for packet in packets for timed in OscPacket(packet).messages]
    assert [message.address for message in messages[:3]] == [
        "/VMC/Ext/OK",
        "/VMC/Ext/T",
        "/VMC/Ext/Root/Pos",
    ]
    assert messages[0].params == [1, 3, 0, 1]
    assert messages[2].params == ["root", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    bones = {m.params[0]: m.params[1:] for m in messages[3:]}
    assert set(bones) == set(humanoid.BONES)
    position, _quaternions = BODY.joint_frames(pose)
    at = position[0]
    assert np.allclose(bones["Hips"][:3], [-at[0], at[2], -at[1]], atol=PLACE)
    x, y, z, w = bones["LeftLowerArm"][3:]
    turn = rot.log([w, x, -y, -z])
    assert np.allclose(turn, pose.rotations[JOINT_INDEX["left_elbow"]], atol=1e-6)


def test_packets_of_an_independent_implementation_are_read():
    from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
    from pythonosc.osc_message_builder import OscMessageBuilder

    pose = any_pose(4)
    builder = OscBundleBuilder(IMMEDIATELY)
    for packet in sent(pose):
        for message in osc.decode(packet):
            made = OscMessageBuilder(message.address)
            for value in message.arguments:
                made.add_arg(value)
            builder.add_content(made.build())
    whole = builder.build().dgram
    got = decoded(VmcDecoder(PERSON, BODY), [whole, whole])
    assert furthest(pose, got[-1].pose) < ANGLE


def test_a_frame_is_complete_with_its_last_bone():
    """From the second frame on nothing is waited for, in whatever order the bones come."""
    pose = any_pose(5)
    messages = [m for packet in sent(pose) for m in osc.decode(packet)]
    decoder = VmcDecoder(PERSON, BODY)
    assert decoded(decoder, map(osc.encode, messages)) == []
    assert len(decoded(decoder, map(osc.encode, messages[::-1]))) == 2
    counts = [len(decoder.decode(osc.encode(message), 0.0)) for message in messages]
    assert counts == [0] * (len(messages) - 1) + [1]


def test_bones_that_go_and_come_back():
    pose = any_pose(6)
    whole = [osc.encode(m) for packet in sent(pose) for m in osc.decode(packet)]
    fewer = [packet for packet in whole if b"Hand\0" not in packet]
    decoder = VmcDecoder(PERSON, BODY)
    poses = decoded(decoder, [*whole, *whole, *fewer, *fewer, *fewer, *whole, *whole])
    wrist = JOINT_INDEX["left_wrist"]
    assert [bool(incoming.tracked[wrist]) for incoming in poses] == [
        *(True, True),
        *(False, False, False),
        *(True, True),
    ]


def test_the_root_carries_the_hips():
    pose = any_pose(7)
    decoder = VmcDecoder(PERSON, BODY)
    root = place("/VMC/Ext/Root/Pos", "root", 1.0, 0.5, 2.0, 0.0, 1.0, 0.0, 0.0)
    packets = [p for m in sent(pose) for p in map(osc.encode, osc.decode(m)) if b"Root" not in p]
    got = decoded(decoder, [root, *packets, *packets])[-1].pose
    half_turn = np.array([0.0, 0.0, np.pi])
    turned = rot.multiply(rot.exp(half_turn), rot.exp(pose.rotations[0]))
    assert np.allclose(rot.log(turned), got.rotations[0], atol=1e-5)
    was = BODY.joints(pose)[0]
    assert np.allclose(BODY.joints(got)[0], [-was[0] - 1.0, -was[1] - 2.0, was[2] + 0.5], atol=1e-5)


def test_devices_and_the_state_are_kept():
    decoder = VmcDecoder(PERSON, BODY)
    decoder.decode(place("/VMC/Ext/Hmd/Pos", "LHR-1", 1.0, 1.7, 2.0, 0.0, 0.0, 0.0, 1.0), 0.0)
    decoder.decode(place("/VMC/Ext/Tra/Pos/Local", "T", 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 0.0)
    decoder.decode(osc.encode(Message("/VMC/Ext/OK", (1, 3, 0))), 0.0)
    assert decoder.status == (1, 3, 0)
    head = decoder.devices["LHR-1"]
    assert (head.kind, head.raw) == ("Hmd", False)
    assert np.allclose(head.position, [-1.0, -2.0, 1.7])
    assert decoder.devices["T"].raw
    for i in range(2 * MAX_DEVICES):
        decoder.decode(place("/VMC/Ext/Con/Pos", f"c{i}", 0, 0, 0, 0, 0, 0, 1), 0.0)
    assert len(decoder.devices) == MAX_DEVICES


def model_with_other_axes(seed):
    """A model whose bones have axes of their own at rest: what it sends of a pose."""
    rng = np.random.default_rng(seed)
    own = rot.normalize(rng.normal(size=(55, 4)))
    rest = BODY.rest_joints

    def packets(pose):
        positions, quaternions = BODY.joint_frames(pose)
        world = rot.multiply(rot.exp([-np.pi / 2, 0.0, 0.0]), quaternions)
        bones = rot.multiply(world, own)
        local = humanoid.CHAIN.local_rotations(bones)
        parents = np.maximum(humanoid.CHAIN.parents, 0)
        offsets = rot.rotate(rot.conjugate(own[parents]), rest - rest[parents])
        x, y, z = positions[0]
        offsets[0] = 0.5 * np.array([x, z, -y])  # half as tall
        rows = [
            (*(o * [-1, 1, 1]), q[1], -q[2], -q[3], q[0])
            for o, q in zip(offsets, local, strict=True)
        ]
        return [bone(name, *row) for name, row in zip(humanoid.BONES, rows, strict=True)]

    return packets


@pytest.mark.parametrize("heading", [0.0, 1.2, -2.5])
def test_a_t_pose_calibrates_any_model(heading):
    """Bones with axes of their own, half our size, and a person who looks anywhere."""
    model = model_with_other_axes(8)
    rest = t_pose()
    turn = rot.multiply(rot.exp([0.0, 0.0, heading]), rot.exp(rest.rotations[0]))
    rotations = rest.rotations.copy()
    rotations[0] = rot.log(turn)
    standing = type(rest)(rest.translation, rotations)
    decoder = VmcDecoder(PERSON, BODY)
    decoded(decoder, model(standing))
    decoder.decode(osc.encode(Message("/VMC/Ext/Set/Calib/Exec", (0,))), 0.0)
    (_, known) = decoded(decoder, model(standing))
    assert furthest(known.pose, standing) < 1e-3
    pose = any_pose(9)
    got = decoded(decoder, model(pose))[-1]
    assert furthest(got.pose, pose) < 1e-3
    assert np.allclose(got.pose.translation, pose.translation, atol=1e-4)


def test_a_models_own_rest_pose_turns_the_limbs():
    """A model in an A-pose, arms 40 degrees down, that says it has no rotation: ours hang too."""
    drop = np.radians(40.0)
    frame = [
        bone("Hips", 0.0, 0.9, 0.0, 0.0, 0.0, 0.0, 1.0),
        bone("LeftUpperArm", -0.2, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0),
        bone("LeftLowerArm", -0.3 * np.cos(drop), -0.3 * np.sin(drop), 0.0, 0.0, 0.0, 0.0, 1.0),
    ]
    got = decoded(VmcDecoder(PERSON, BODY), frame * 2)[-1]
    positions = BODY.joints(got.pose)
    arm = positions[JOINT_INDEX["left_elbow"]] - positions[JOINT_INDEX["left_shoulder"]]
    assert np.allclose(arm / np.linalg.norm(arm), [np.cos(drop), 0.0, -np.sin(drop)], atol=1e-6)


def half_a_model(pose):
    """A frame in messages of one bone each, of a model of half our size."""
    half = []
    for message in (m for packet in sent(pose) for m in osc.decode(packet)):
        name, *values = message.arguments or ("",)
        if message.address == "/VMC/Ext/Bone/Pos":
            values = [*(0.5 * x for x in values[:3]), *values[3:]]
            message = Message(message.address, (name, *values))
        half.append(osc.encode(message))
    return half


def test_a_models_legs_give_the_scale():
    """A model of half our size: what it goes is as far for us in legs, and so is its height."""
    pose = any_pose(11)
    got = decoded(VmcDecoder(PERSON, BODY), half_a_model(pose) * 2)[-1]
    assert furthest(got.pose, pose) < ANGLE
    assert np.allclose(got.pose.translation, pose.translation, atol=PLACE)


@pytest.mark.parametrize("lost", ["LeftFoot", "LeftLowerLeg", "RightUpperLeg", "LeftLowerArm"])
def test_a_packet_that_is_lost_leaves_the_model_as_it_is(lost):
    """The bone is not tracked for a frame; the person is where they are, and as large."""
    pose = any_pose(12)
    whole = half_a_model(pose)
    fewer = [packet for packet in whole if padded(lost) not in packet]
    assert len(fewer) == len(whole) - 1
    poses = decoded(VmcDecoder(PERSON, BODY), [*whole, *whole, *fewer, *whole, *whole])
    assert [int(incoming.tracked.sum()) for incoming in poses] == [55, 55, 54, 55, 55]
    for incoming in poses:
        assert np.allclose(incoming.pose.translation, pose.translation, atol=PLACE)


@pytest.mark.parametrize(
    ("lost", "joint", "other"),
    [("LowerArm", "left_elbow", "left_shoulder"), ("UpperArm", "left_shoulder", "left_elbow")],
)
def test_a_packet_that_is_lost_turns_no_limb(lost, joint, other):
    """Of a model in an A-pose: one part of the arm hangs as before while the other is missing."""
    drop = np.radians(40.0)
    frame = [
        bone("Hips", 0.0, 0.9, 0.0, 0.0, 0.0, 0.0, 1.0),
        bone("LeftUpperArm", -0.2, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0),
        bone("LeftLowerArm", -0.3 * np.cos(drop), -0.3 * np.sin(drop), 0.0, 0.0, 0.0, HALF, HALF),
        bone("LeftHand", -0.3 * np.cos(drop), -0.3 * np.sin(drop), 0.0, 0.0, 0.0, 0.0, 1.0),
    ]
    fewer = [packet for packet in frame if padded(f"Left{lost}") not in packet]
    poses = decoded(VmcDecoder(PERSON, BODY), [*frame * 2, *fewer, *frame * 2])
    missing = [not incoming.tracked[JOINT_INDEX[joint]] for incoming in poses]
    assert missing == [False, False, True, False, False]
    turns = np.array([incoming.pose.rotations[JOINT_INDEX[other]] for incoming in poses])
    assert np.allclose(turns, turns[0], atol=1e-12)
    assert np.linalg.norm(turns[0]) > 0.5


def bones(pose):
    """A frame in messages of one bone each, without those that are no bones."""
    messages = [m for packet in sent(pose) for m in osc.decode(packet)]
    return [osc.encode(m) for m in messages if "Bone" in m.address]


@pytest.mark.parametrize("lost", [slice(0, 1), slice(0, 20), slice(20, 40), slice(40, 55)])
def test_frames_after_lost_packets_are_whole_and_in_time(lost):
    """Every pose is of one frame, and comes with the last packet of its frame."""
    frames = [bones(any_pose(seed)) for seed in range(20, 28)]
    references = decoded(VmcDecoder(PERSON, BODY), [p for f in frames for p in f])
    del frames[3][lost]
    decoder = VmcDecoder(PERSON, BODY)
    counts, poses = [], []
    for frame in frames:
        came = [decoder.decode(packet, 0.0) for packet in frame]
        counts.append(len(came[-1]))
        poses += [incoming for now in came for incoming in now]
    assert counts[4:] == [1, 1, 1, 1]
    if lost.start == 0:  # no hips, no pose
        del references[3]
    assert [int((~incoming.tracked).sum()) for incoming in poses if not incoming.tracked.all()] == (
        [] if lost.start == 0 else [lost.stop - lost.start]
    )
    for incoming, reference in zip(poses, references, strict=True):
        if incoming.tracked.all():
            assert furthest(incoming.pose, reference.pose) < ANGLE


def test_a_frame_that_lacks_a_bone_calibrates_nothing():
    """The next whole frame does."""
    frame = bones(t_pose())
    lowered = t_pose().rotations.copy()
    lowered[JOINT_INDEX["left_shoulder"]] = [0.0, 0.0, -1.0]
    low = bones(type(t_pose())(t_pose().translation, lowered))
    fewer = [packet for packet in low if padded("LeftUpperArm") not in packet]
    decoder = VmcDecoder(PERSON, BODY)
    decoded(decoder, frame * 2)
    decoder.calibrate()
    got = decoded(decoder, [*fewer, *low, *low])[-1]
    assert furthest(got.pose, t_pose()) < ANGLE


def test_another_model_is_fitted_anew():
    pose = any_pose(13)
    whole = [osc.encode(m) for packet in sent(pose) for m in osc.decode(packet)]
    decoder = VmcDecoder(PERSON, BODY)
    decoded(decoder, half_a_model(pose) * 2)
    got = decoded(decoder, whole * 2)[-1]
    assert np.allclose(got.pose.translation, pose.translation, atol=PLACE)


def test_nobody_is_not_sent():
    (packet,) = sent(None)
    assert osc.decode(packet)[0] == Message("/VMC/Ext/OK", (0, 3, 0, 0))
    assert decoded(VmcDecoder(PERSON, BODY), [packet]) == []


@pytest.mark.parametrize(
    "packet",
    [
        osc.encode(Message("/VMC/Ext/Bone/Pos", ("Hips", 1.0))),
        osc.encode(Message("/VMC/Ext/Bone/Pos", (1.0,) * 8)),
        osc.encode(Message("/VMC/Ext/Bone/Pos", ("Hips", *"1234567"))),
        bone("Hips", 0, 0, 0, 0, 0, 0, 0),
        bone("Hips", float("nan"), 0, 0, 0, 0, 0, 1),
        bone("Hips", 0, float("inf"), 0, 0, 0, 0, 1),
        bone("Hips", 0, 1e30, 0, 0, 0, 0, 1),
        osc.encode(Message("/VMC/Ext/T", ("late",))),
        osc.encode(Message("/VMC/Ext/OK")),
    ],
)
def test_wrong_messages_are_refused_and_change_nothing(packet):
    decoder = VmcDecoder(PERSON, BODY)
    good = [osc.encode(m) for p in sent(any_pose(10)) for m in osc.decode(p)]
    expected = decoded(decoder, good * 2)[-1].pose
    with pytest.raises(Malformed):
        decoder.decode(osc.bundle([good[3], packet]), 0.0)
    got = decoded(decoder, good)[-1].pose
    assert np.array_equal(got.rotations, expected.rotations)


VALUE = st.floats(width=32) | st.integers(-(2**31), 2**31 - 1) | st.text(max_size=5)
NAME = st.sampled_from([*humanoid.BONES[:6], "LastBone", "root", ""])
ADDRESS = st.sampled_from(
    [
        *("/VMC/Ext/Bone/Pos", "/VMC/Ext/Root/Pos", "/VMC/Ext/T", "/VMC/Ext/OK"),
        *("/VMC/Ext/Hmd/Pos", "/VMC/Ext/Set/Calib/Exec", "/VMC/Ext/Blend/Val", "/x"),
    ]
)
ODD = st.builds(lambda a, n, v: Message(a, (n, *v)), ADDRESS, NAME, st.lists(VALUE, max_size=9))


@settings(max_examples=200)
@given(st.lists(ODD, max_size=12), st.binary(max_size=60))
def test_noise_is_read_or_refused(messages, noise):
    """Nothing but `Malformed` is raised, and poses are finite."""
    decoder = VmcDecoder(PERSON, BODY)
    packets = [noise]
    for message in messages:
        try:
            packets.append(osc.encode(message))
        except (TypeError, UnicodeEncodeError):
            continue
    for packet in packets:
        try:
            for incoming in decoder.decode(packet, 0.0):
                assert np.isfinite(incoming.pose.rotations).all()
        except Malformed:
            pass
