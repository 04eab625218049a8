"""Skeletons of other programs on the SMPL-X body: names, rest poses, frames, units, spines."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from bvh_files import MIXAMO, pointing, retold, text_of
from layouts import movement
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics import rotations as rot
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.io.bvh_text import read_bvh
from halfphysics.io.skeleton_maps import match_joints
from halfphysics.io.source_skeleton import SourceSkeleton
from halfphysics.skeleton import FACE_JOINTS, JOINT_INDEX, JOINT_NAMES, PARENTS

SAME = 1e-6  # metres: files have 1e-9 of a centimetre or degree
# Where bones are taken to be along an axis at rest: the default body's are to a few micrometres.
NEAR = 2e-5
BODY = hp.Body.default()
ARMS = ("shoulder", "elbow", "wrist")
HAND = ("thumb", "index", "middle", "ring", "pinky")
FINGERS = ("index", "middle", "pinky", "ring", "thumb")


def motion_of(frames: int = 16) -> hp.Motion:
    translation, rotations = movement(frames)
    rotations[:, list(FACE_JOINTS)] = 0.0
    return hp.Motion(translation, rotations, 30.0)


def read(path, **options) -> hp.Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        return hp.Motion.load(path, **options)


def loaded(tmp_path, text: str, **options) -> hp.Motion:
    (tmp_path / "a.bvh").write_text(text)
    return read(tmp_path / "a.bvh", **options)


def off(one: hp.Motion, other: hp.Motion) -> float:
    return float(np.abs(BODY.vertices(one) - BODY.vertices(other)).max())


def renamed(how) -> dict[int, str]:
    return {joint: how(name) for joint, name in MIXAMO.items()}


def smpl_like(joint: int) -> str:
    name = JOINT_NAMES[joint].replace("left_", "L_").replace("right_", "R_")
    return name[:2] + name[2:].capitalize()


_BIPED = {"hip": "Thigh", "knee": "Calf", "ankle": "Foot", "foot": "Toe0", "collar": "Clavicle"}
_BIPED |= {"shoulder": "UpperArm", "elbow": "Forearm", "wrist": "Hand"}
_UNREAL = {"hip": "thigh", "knee": "calf", "ankle": "foot", "foot": "ball", "collar": "clavicle"}
_UNREAL |= {"shoulder": "upperarm", "elbow": "lowerarm", "wrist": "hand"}
_OLD = {"hip": "Hip", "knee": "Knee", "ankle": "Ankle", "foot": "Toe", "collar": "Collar"}
_OLD |= {"shoulder": "Shoulder", "elbow": "Elbow", "wrist": "Wrist"}
_ASF = {"hip": "femur", "knee": "tibia", "ankle": "foot", "foot": "toes", "collar": "clavicle"}
_ASF |= {"shoulder": "humerus", "elbow": "radius", "wrist": "wrist"}
_RIGIFY = {"hip": "thigh", "knee": "shin", "ankle": "foot", "foot": "toe", "collar": "shoulder"}
_RIGIFY |= {"shoulder": "upper_arm", "elbow": "forearm", "wrist": "hand"}
_ROKOKO_PARTS = {"1": "Proximal", "2": "Medial", "3": "Distal"}


def styled(limb: dict[str, str], name_limb, name_finger) -> dict[int, str]:
    """Names of limbs and fingers in a style; the trunk as in Mixamo."""
    names = {}
    for joint, mixamo in MIXAMO.items():
        side, _, part = JOINT_NAMES[joint].partition("_")
        if side not in ("left", "right"):
            names[joint] = mixamo
        elif part in limb:
            names[joint] = name_limb(side, limb[part])
        elif name_finger is not None:
            names[joint] = name_finger(side, part[:-1], part[-1])
    return names


STYLES = {
    "Mixamo": MIXAMO,
    "mixamorig:": renamed(lambda n: f"mixamorig:{n}"),
    "mixamorig_": renamed(lambda n: f"mixamorig_{n}"),
    "mixamorig1": renamed(lambda n: f"mixamorig1:{n}"),
    "a namespace": renamed(lambda n: f"Bob:rig:{n}"),
    "lower case": renamed(lambda n: n.replace("Left", "left_").replace("Right", "right_").lower()),
    "MotionBuilder": renamed(lambda n: f"Character1_{n}"),
    "SMPL": {j: smpl_like(j) for j in MIXAMO},
    "Biped": styled(
        _BIPED,
        lambda s, n: f"Bip01 {s[0].upper()} {n}",
        lambda s, f, k: (
            f"Bip01 {s[0].upper()} Finger{HAND.index(f)}{'' if k == '1' else int(k) - 1}"
        ),
    ),
    "Unreal": styled(_UNREAL, lambda s, n: f"{n}_{s[0]}", lambda s, f, k: f"{f}_0{k}_{s[0]}"),
    "Rigify": styled(
        _RIGIFY,
        lambda s, n: f"DEF-{n}.{s[0].upper()}",
        lambda s, f, k: f"DEF-f_{f}.0{k}.{s[0].upper()}".replace("f_thumb", "thumb"),
    ),
    "Rokoko": styled(
        {**_OLD, "hip": "Thigh", "knee": "Shin", "ankle": "Foot", "shoulder": "Arm"}
        | {"collar": "Shoulder", "elbow": "ForeArm", "wrist": "Hand"},
        lambda s, n: f"{s.capitalize()}{n}",
        lambda s, f, k: (
            f"{s.capitalize()}Finger{HAND.index(f) + 1}"
            + (
                {"1": "Metacarpal", "2": "Proximal", "3": "Distal"}
                if f == "thumb"
                else _ROKOKO_PARTS
            )[k]
        ),
    ),
    "old": styled(_OLD, lambda s, n: f"{s.capitalize()}{n}", None),
    "CMU asf": styled(_ASF, lambda s, n: f"{s[0]}{n}", None),
    "rThigh": styled(_BIPED, lambda s, n: f"{s[0]}{n.replace('Toe0', 'Toe')}", None),
}


@pytest.mark.parametrize("style", STYLES)
def test_names(tmp_path, style):
    """The body itself under other names: the same vertices come back."""
    names, motion = STYLES[style], motion_of()
    rotations = np.array(motion.rotations)
    rotations[:, [j for j in range(55) if j not in names]] = 0.0
    motion = motion.with_frames(motion.translation, rotations)
    assert off(loaded(tmp_path, retold(motion, BODY, names=names)), motion) < SAME


REAL = {
    # What the data sets' own files have, beyond what one joint per joint shows.
    "LAFAN1": (
        "Hips LeftUpLeg LeftLeg LeftFoot LeftToe RightUpLeg RightLeg RightFoot RightToe Spine"
        " Spine1 Spine2 Neck Head LeftShoulder LeftArm LeftForeArm LeftHand RightShoulder RightArm"
        " RightForeArm RightHand",
        [-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 12, 11, 14, 15, 16, 11, 18, 19, 20],
        {"left_collar": "LeftShoulder", "left_shoulder": "LeftArm", "left_foot": "LeftToe"},
    ),
    "CMU": (
        "Hips LHipJoint LeftUpLeg LeftLeg LeftFoot LeftToeBase RHipJoint RightUpLeg RightLeg"
        " RightFoot RightToeBase LowerBack Spine Spine1 Neck Neck1 Head LeftShoulder LeftArm"
        " LeftForeArm LeftHand LeftFingerBase LeftHandIndex1 LThumb RightShoulder RightArm"
        " RightForeArm RightHand RightFingerBase RightHandIndex1 RThumb",
        [
            *(-1, 0, 1, 2, 3, 4, 0, 6, 7, 8, 9, 0, 11, 12, 13, 14, 15),
            *(13, 17, 18, 19, 20, 21, 20, 13, 24, 25, 26, 27, 28, 27),
        ],
        {"left_hip": "LeftUpLeg", "neck": "Neck", "right_index1": "RightHandIndex1"}
        | {"left_thumb1": "LThumb", "left_wrist": "LeftHand"},
    ),
    "metacarpals and tips": (
        "hips thigh_l calf_l thigh_r calf_r foot_l foot_r spine upperarm_l lowerarm_l hand_l"
        " upperarm_r lowerarm_r hand_r index_metacarpal_l index_01_l index_02_l index_03_l"
        " index_03_end_l thumb_01_l upperarm_twist_01_l LeftHandMiddle0 LeftHandMiddle1"
        " LeftHandMiddle2 LeftHandMiddle3",
        [-1, 0, 1, 0, 3, 2, 4, 0, 7, 8, 9, 7, 11, 12, 10, 14, 15, 16, 17, 10, 8, 10, 21, 22, 23],
        {"left_index1": "index_01_l", "left_index3": "index_03_l", "left_thumb1": "thumb_01_l"}
        | {"left_shoulder": "upperarm_l", "left_middle1": "LeftHandMiddle1"},
    ),
}


@pytest.mark.parametrize("style", REAL)
def test_real_skeletons_names(style):
    text, parents, expected = REAL[style]
    names = text.split()
    found = match_joints(names, parents)
    assert len(set(found.values())) == len(found)
    assert {ours: names[found[JOINT_INDEX[ours]]] for ours in expected} == expected
    for side in ("left", "right"):
        for joint in ("hip", "knee", "ankle", *ARMS):
            assert names[found[JOINT_INDEX[f"{side}_{joint}"]]].lower().find(side[0]) >= 0


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("unit", [1.0, 100.0, 17.7])
def test_units_and_axes(tmp_path, unit, up):
    """Metres, centimetres, anything: the legs say it. The body says which way is up."""
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
    """Frames along the bones: hinges, branches and the mean tell the rest, to the last digit."""
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
    """However many joints, spine3 is turned as the last of them, the arms as the arms."""
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
    # the bone by itself; collars and feet keep the rest pose, where the skeletons differ.
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
    motion, source = read(path), SourceSkeleton.of("", read_bvh(path))
    places = source.frames(slice(None))[0] @ motion.axes.T
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
    # Faces forward of the pelvis as the toes do: left is left.
    left = joints[:, 16] - joints[:, 17]
    toes = (joints[:, 10] + joints[:, 11] - joints[:, 7] - joints[:, 8]) / 2
    ahead = np.cross(left, [0.0, 0.0, 1.0])
    assert ((ahead * toes).sum(axis=1) > 0.0).mean() > 0.8
    lowest = BODY.vertices(motion, frames=slice(None, None, 5))[..., 2].min()
    assert -0.05 < lowest < 0.03
    # Knees and elbows bend the way they do, about the hinge only.
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
    motion, source = read(path), SourceSkeleton.of("", read_bvh(path))
    quaternions = source.frames(slice(None))[1]
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
    """Each joint of each finger by itself, in frames along the bones, on the vertices."""
    translation, rotations = movement(16)
    rotations[:, 1:25] = 0.0
    bent = np.abs(rotations[:, 25:, 2:])
    rotations[:, 25:] = bent * np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], 15, axis=0)
    motion = hp.Motion(translation, rotations, 30.0)
    found = loaded(tmp_path, retold(motion, BODY, own=a_pose()))
    assert np.ptp(found.rotations[:, 25:, 2], axis=0).min() > 0.001
    assert off(found, motion) < NEAR
