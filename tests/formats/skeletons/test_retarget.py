"""Skeletons of other programs on the SMPL-X body: names, rest poses, frames, units, spines."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.bvh.channels import animated
from halfphysics.formats.bvh.text import read_bvh
from halfphysics.formats.skeletons.source_skeleton import SourceSkeleton
from halfphysics.motion.skeleton import FACE_JOINTS, JOINT_INDEX, JOINT_NAMES, PARENTS
from support.files.bvh_files import MIXAMO, pointing, retold, text_of
from support.files.layouts import movement

SAME = 1e-6  # metres: files have 1e-9 of a centimetre or degree
# Where bones are assumed along an axis at rest: the default body's are to a few micrometres.
NEAR = 2e-5
BODY = hp.Body.default()
ARMS = ("shoulder", "elbow", "wrist")
FINGERS = ("index", "middle", "pinky", "ring", "thumb")


def motion_of(frames: int = 16) -> hp.Motion:
    translation, rotations = movement(frames)
    rotations[:, list(FACE_JOINTS)] = 0.0
    return hp.Motion(translation, rotations, 30.0)


def read(path, **options) -> hp.Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return hp.Motion.load(path, **options)


def source_of(path) -> SourceSkeleton:
    return SourceSkeleton.of("", animated(read_bvh(path), slice(None)))


def loaded(tmp_path, text: str, **options) -> hp.Motion:
    (tmp_path / "a.bvh").write_text(text)
    return read(tmp_path / "a.bvh", **options)


def off(one: hp.Motion, other: hp.Motion) -> float:
    return float(np.abs(BODY.vertices(one) - BODY.vertices(other)).max())


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("unit", [1.0, 100.0, 17.7])
def test_units_and_axes(tmp_path, unit, up):
    """Metres, centimetres or any unit: found by the legs. The body shows which way is up."""
    motion = motion_of()
    own = None
    if up == "z":  # at the zero pose it stands along z, too
        own = np.tile(rot.exp([-np.pi / 2, 0.0, 0.0]), (55, 1))
    text = retold(motion, BODY, unit=unit, up=up, own=own)
    assert off(loaded(tmp_path, text), motion) < SAME
    assert off(loaded(tmp_path, text, up=up), motion) < SAME


def a_pose(degrees: float = 60.0) -> np.ndarray:
    """SMPL-X from file joints where arms and hands hang at the zero pose."""
    own = np.tile([1.0, 0.0, 0.0, 0.0], (55, 1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        turn = rot.exp([0.0, 0.0, sign * np.radians(degrees)])
        for joint, name in enumerate(JOINT_NAMES):
            if name.startswith(side) and any(p in name for p in (*ARMS, *FINGERS)):
                own[joint] = turn
    return own


@pytest.mark.parametrize("degrees", [20.0, 60.0, 88.0])
def test_rest_with_hanging_arms(tmp_path, degrees):
    motion = motion_of()
    assert off(loaded(tmp_path, retold(motion, BODY, own=a_pose(degrees))), motion) < NEAR


def test_rest_with_legs_apart(tmp_path):
    """The shortest turn of the legs; the feet stay flat at rest."""
    own = np.tile([1.0, 0.0, 0.0, 0.0], (55, 1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for joint in ("hip", "knee"):
            own[JOINT_INDEX[f"{side}_{joint}"]] = rot.exp([0.0, 0.0, -sign * 0.3])
    motion = motion_of()
    # The thigh's bone is not quite along y: the shortest turn is not quite about z.
    assert off(loaded(tmp_path, retold(motion, BODY, own=own)), motion) < 1e-3


def along_x(seed: int = 0) -> np.ndarray:
    """SMPL-X from file joints, every bone along its own x axis, as in LAFAN1 and MotionBuilder.

    The twist of limbs about the bone is random: no two programs agree.
    """
    rng, own = np.random.default_rng(seed), np.empty((55, 4))
    trunk = rot.from_matrix(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    for joint, name in enumerate(JOINT_NAMES):
        if name in ("pelvis", "spine1", "spine2", "spine3", "neck", "head"):
            own[joint] = trunk if joint else [1.0, 0.0, 0.0, 0.0]
            continue
        swing, _ = Rotation.align_vectors([pointing(joint, BODY)], [[1.0, 0.0, 0.0]])
        twist = Rotation.from_rotvec([rng.uniform(0, 2 * np.pi), 0.0, 0.0])
        own[joint] = (swing * twist).as_quat()[[3, 0, 1, 2]]
    return own


def test_zero_pose_that_is_no_posture(tmp_path):
    """Frames along the bones: hinges, branches and the mean give the rest, to the last digit."""
    translation, rotations = movement(24)
    t = np.linspace(0.0, 1.0, 24)
    moved = np.zeros_like(rotations)
    moved[:, 0] = rotations[:, 0]
    for side, out in (("left", 1.0), ("right", -1.0)):
        j = {name: JOINT_INDEX[f"{side}_{name}"] for name in ("hip", "knee", "elbow", "wrist")}
        moved[:, j["hip"]] = rotations[:, j["hip"]]
        shoulder = JOINT_INDEX[f"{side}_shoulder"]
        moved[:, shoulder] = rotations[:, shoulder]
        moved[:, j["knee"], 0] = 0.8 + 0.5 * np.sin(5 * t)
        moved[:, j["elbow"], 1] = -out * (0.9 + 0.4 * np.sin(6 * t))
        moved[:, j["wrist"]] = rotations[:, j["wrist"]]
    spine = [JOINT_INDEX[f"spine{k}"] for k in (1, 2, 3)]
    moved[:, spine] = 0.5 * rotations[:, spine[:1]]  # one arc in three equal parts
    motion = hp.Motion(translation, moved, 30.0)
    found = loaded(tmp_path, retold(motion, BODY, own=along_x()))
    # Hinges are about the axes that are assumed; the default body's bones are square to them to
    # a thousandth.
    assert off(found, motion) < 3e-3
    assert np.abs(BODY.joints(found) - BODY.joints(motion)).max() < 3e-3


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5])
def test_spine_chains(tmp_path, count):
    """However many joints, spine3 turns as the last of them, the arms as the arms."""
    rng = np.random.default_rng(count)
    keep = [j for j in sorted(MIXAMO) if not JOINT_NAMES[j].startswith("spine")]
    names = ["Hips", *(f"Spine{k or ''}" for k in range(count))]
    parents = [-1, *range(count)]
    rest = [BODY.rest_joints[0]]
    top = BODY.rest_joints[9]
    rest += [rest[0] + (top - rest[0]) * (k + 1) / count for k in range(count)]
    places = {0: 0, 3: count, 6: count, 9: count}
    for joint in keep[1:]:
        places[joint] = len(names)
        parents.append(places[int(PARENTS[joint])])
        names.append(MIXAMO[joint])
        rest.append(BODY.rest_joints[joint])
    rest, frames = np.array(rest), 9
    offsets = 100.0 * np.array([rest[i] - rest[max(p, 0)] for i, p in enumerate(parents)])
    t = np.linspace(0.0, 2.0, frames)[:, None, None]
    local = rot.exp(np.sin(t + rng.uniform(0, 6, (len(names), 3))) * 0.3)
    world = local.copy()
    for i, parent in enumerate(parents):
        if parent >= 0:
            world[:, i] = rot.multiply(world[:, parent], local[:, i])
    found = loaded(tmp_path, text_of(names, parents, offsets, local, np.full((frames, 3), 90.0)))
    turn = rot.from_matrix(found.axes)
    ours = BODY.joint_frames(found)[1]

    def differ(joint: str, theirs: np.ndarray) -> float:
        expected = rot.multiply(turn, theirs)
        delta = rot.multiply(rot.conjugate(expected), ours[:, JOINT_INDEX[joint]])
        return float(np.abs(rot.log(delta)).max())

    same = 1e-10  # radians: twelve digits of degrees in the file
    assert differ("pelvis", world[:, 0]) < same
    assert differ("spine3", world[:, count]) < same
    for joint in ("neck", "left_shoulder", "right_elbow", "left_knee", "head", "left_index2"):
        assert differ(joint, world[:, places[JOINT_INDEX[joint]]]) < same
    if count == 3:
        assert differ("spine1", world[:, 1]) < same
        assert differ("spine2", world[:, 2]) < same
    if count == 1:
        parts = found.rotations[:, [3, 6, 9]]
        assert np.abs(parts - parts[:, :1]).max() < same


def test_joints_split_in_one_place(tmp_path):
    """As CMU's hands: the wrist twists in one joint and bends in the next, 0 away."""
    motion = motion_of()
    names = {j: n for j, n in MIXAMO.items() if "Hand" not in n} | {
        JOINT_INDEX[f"{side}_{ours}"]: f"{side.capitalize()}{theirs}"
        for side in ("left", "right")
        for ours, theirs in (("wrist", "Hand"), ("middle1", "FingerBase"), ("index1", "Twist"))
    }
    # The substitute for its only finger gives the wrist's turn; a twist joint turns nothing.
    places = np.array(BODY.rest_joints)
    rotations = np.array(motion.rotations)
    rotations[:, 25:] = 0.0
    whole = motion.with_frames(motion.translation, rotations)
    for side in ("left", "right"):
        wrist, base, twist, tip = (
            JOINT_INDEX[f"{side}_{n}"] for n in ("wrist", "middle1", "index1", "middle2")
        )
        names[tip] = f"{side.capitalize()}HandIndex1"
        places[tip], places[base], places[twist] = places[base], places[wrist], places[wrist]
        rotations[:, base] = 0.7 * rotations[:, wrist]
        rotations[:, wrist] = 0.3 * rotations[:, wrist]
        rotations[:, twist, 0] = 0.4
    body = dataclasses.replace(BODY, rest_joints=places)
    split = motion.with_frames(motion.translation, rotations)
    found = loaded(tmp_path, retold(split, body, names=names))
    places = BODY.joints(found)[:, :22] - BODY.joints(whole)[:, :22]
    assert np.abs(places).max() < NEAR
    assert np.abs(found.rotations[:, :22] - whole.rotations[:, :22]).max() < NEAR


def test_joints_that_are_not_there_stay_at_rest_and_are_said_once(tmp_path):
    names = {j: n for j, n in MIXAMO.items() if "Hand" not in n and "Toe" not in n}
    names |= {JOINT_INDEX["left_wrist"]: "LeftHand", JOINT_INDEX["jaw"]: "Hat"}
    (tmp_path / "a.bvh").write_text(retold(motion_of(), BODY, names=names))
    with pytest.warns(HalfPhysicsWarning) as caught:
        found = hp.Motion.load(tmp_path / "a.bvh")
    assert len(caught) == 1
    said = str(caught[0].message)
    assert "a.bvh" in said
    assert "unit cm" in said
    assert "y up" in said
    assert "left_foot, right_foot, right_wrist, all fingers" in said
    assert said.endswith("not used of the file: Hat")
    gone = [j for j in range(55) if j not in names or j == JOINT_INDEX["jaw"]]
    assert not found.rotations[:, gone].any()


CLIPS = {
    # Name -> farthest a bone may point from the source's [degrees]: 0 where both skeletons have
    # an equal bone; collars and feet keep the rest pose, where the skeletons differ.
    "dab": {"collar": 3.0, "ankle": 1.0},
    "jumping": {"collar": 3.0, "ankle": 1.0},
    "jumping_jacks": {"collar": 14.0, "ankle": 3.0},
    "jesse_dance": {},
}
BONES = [
    ("hip", "knee"),
    ("knee", "ankle"),
    ("ankle", "foot"),
    ("collar", "shoulder"),
    ("shoulder", "elbow"),
    ("elbow", "wrist"),
    *((f"{finger}{k}", f"{finger}{k + 1}") for finger in FINGERS for k in (1, 2)),
]
EXACT = 1e-5  # degrees


@pytest.mark.parametrize("clip", CLIPS)
def test_bones_of_real_clips_point_as_in_the_source(shared_data, clip):
    path = shared_data / "motion" / f"animdraw_{clip}.bvh"
    motion, source = read(path), source_of(path)
    places = source.skeleton.positions @ motion.axes.T
    ours, seen = BODY.joints(motion), 0
    for side in ("left", "right"):
        for name, then in BONES:
            a, b = JOINT_INDEX[f"{side}_{name}"], JOINT_INDEX[f"{side}_{then}"]
            if a not in source.joints or b not in source.joints:
                continue
            theirs = places[:, source.joints[b]] - places[:, source.joints[a]]
            mine = ours[:, b] - ours[:, a]
            sine = np.linalg.norm(np.cross(theirs, mine), axis=1)
            angle = np.degrees(np.arctan2(sine, (theirs * mine).sum(axis=1)))
            assert angle.max() < CLIPS[clip].get(name, EXACT), (side, name)
            seen += 1
    assert seen == (32 if clip == "jesse_dance" else 12)


@pytest.mark.parametrize("clip", CLIPS)
def test_real_clips_are_upright_on_the_floor_and_slow_enough(shared_data, clip):
    motion = read(shared_data / "motion" / f"animdraw_{clip}.bvh")
    joints = BODY.joints(motion)
    assert (joints[:, JOINT_INDEX["head"], 2] > joints[:, 0, 2] + 0.3).mean() > 0.9
    # Faces the way the toes do from the pelvis: left is left.
    left = joints[:, 16] - joints[:, 17]
    toes = (joints[:, 10] + joints[:, 11] - joints[:, 7] - joints[:, 8]) / 2
    ahead = np.cross(left, [0.0, 0.0, 1.0])
    assert ((ahead * toes).sum(axis=1) > 0.0).mean() > 0.8
    lowest = BODY.vertices(motion, frames=slice(None, None, 5))[..., 2].min()
    assert -0.05 < lowest < 0.03
    # Knees and elbows bend in the right direction, about the hinge only.
    for side, out in (("left", 1.0), ("right", -1.0)):
        assert motion.rotations[:, JOINT_INDEX[f"{side}_knee"], 0].mean() > 0.2
        elbow = motion.rotations[:, JOINT_INDEX[f"{side}_elbow"]]
        assert -out * elbow[:, 1].mean() > 0.2
        assert np.abs(motion.rotations[:, JOINT_INDEX[f"{side}_shoulder"]]).max() < 3.2
    neck_and_head = motion.rotations[:, [JOINT_INDEX["neck"], JOINT_INDEX["head"]]]
    assert np.linalg.norm(neck_and_head, axis=-1).max() < 1.3


def test_fingers_of_the_dance_are_curled_as_in_the_source(shared_data):
    """18 degrees at each joint, all the time: the clip has no movement in its hands."""
    path = shared_data / "motion" / "animdraw_jesse_dance.bvh"
    motion, source = read(path), source_of(path)
    quaternions = source.skeleton.quaternions
    for side in ("left", "right"):
        for finger in FINGERS:
            bones = [source.joints[JOINT_INDEX[f"{side}_{finger}{k}"]] for k in (1, 2)]
            one, two = quaternions[:, bones[0]], quaternions[:, bones[1]]
            theirs = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(one), two)), axis=1)
            middle = motion.rotations[:, JOINT_INDEX[f"{side}_{finger}2"]]
            # The bones of the default body's hand are not quite straight at rest.
            assert np.abs(np.linalg.norm(middle, axis=1) - theirs).max() < np.radians(12.0)
            if finger not in ("thumb", "index") or side == "left":
                assert np.linalg.norm(middle, axis=1).min() > 0.1


def test_moving_fingers_move(tmp_path):
    """Each joint of each finger alone, in frames along the bones, on the vertices."""
    translation, rotations = movement(16)
    rotations[:, 1:25] = 0.0
    bent = np.abs(rotations[:, 25:, 2:])
    rotations[:, 25:] = bent * np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], 15, axis=0)
    motion = hp.Motion(translation, rotations, 30.0)
    found = loaded(tmp_path, retold(motion, BODY, own=a_pose()))
    assert np.ptp(found.rotations[:, 25:, 2], axis=0).min() > 0.001
    assert off(found, motion) < NEAR
