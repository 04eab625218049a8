"""Names of other programs' skeletons: which joint is which."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.skeletons.skeleton_maps import match_joints
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from support.files.bvh_files import MIXAMO, retold
from support.files.layouts import movement

SAME = 1e-6  # metres: files have 1e-9 of a centimetre or degree
BODY = hp.Body.default()
HAND = ("thumb", "index", "middle", "ring", "pinky")


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
    "VRM": {
        joint: name if "_Bip_" in name else f"J_Bip_C_{name}"
        for joint, name in styled(
            {**_BIPED, "hip": "UpperLeg", "knee": "LowerLeg", "foot": "ToeBase"}
            | {"collar": "Shoulder", "elbow": "LowerArm"},
            lambda s, n: f"J_Bip_{s[0].upper()}_{n}",
            lambda s, f, k: f"J_Bip_{s[0].upper()}_{f.replace('pinky', 'little').capitalize()}{k}",
        ).items()
    },
    "Axis Studio": renamed(lambda n: f"Robot_{n}"),
    "Sketchfab": {j: f"{n}_{k:02d}" for k, (j, n) in enumerate(MIXAMO.items(), 2)},
    "a second one in Blender": renamed(lambda n: f"mixamorig:{n}.001"),
    "Daz": styled(
        {**_BIPED, "hip": "ThighBend", "knee": "Shin", "foot": "Toe", "collar": "Collar"}
        | {"shoulder": "ShldrBend", "elbow": "ForearmBend"},
        lambda s, n: f"{s[0]}{n}",
        lambda s, f, k: f"{s[0]}{f.replace('middle', 'mid').capitalize()}{k}",
    ),
    "Motive": styled(
        {**_BIPED, "knee": "Shin", "foot": "Toe", "collar": "Shoulder"}
        | {"shoulder": "UArm", "elbow": "FArm"},
        lambda s, n: f"Skeleton 001:{s[0].upper()}{n}",
        None,
    ),
    "MakeHuman": styled(
        {**_BIPED, "hip": "upperleg01", "knee": "lowerleg01", "foot": "toe", "wrist": "wrist"}
        | {"collar": "clavicle", "shoulder": "upperarm01", "elbow": "lowerarm01"},
        lambda s, n: f"{n}.{s[0].upper()}",
        lambda s, f, k: f"finger{HAND.index(f) + 1}-{k}.{s[0].upper()}",
    ),
    "rThigh": styled(_BIPED, lambda s, n: f"{s[0]}{n.replace('Toe0', 'Toe')}", None),
}


@pytest.mark.parametrize("style", STYLES)
def test_names(tmp_path, style):
    """The body itself under other names: the same vertices come back."""
    names, (translation, rotations) = STYLES[style], movement(16)
    rotations[:, [j for j in range(55) if j not in names]] = 0.0
    motion = hp.Motion(translation, rotations, 30.0)
    (tmp_path / "a.bvh").write_text(retold(motion, BODY, names=names))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HalfPhysicsWarning)
        found = hp.Motion.load(tmp_path / "a.bvh")
    assert np.abs(BODY.vertices(found) - BODY.vertices(motion)).max() < SAME


REAL = {
    # Names in the data sets' own files, beyond one joint per joint.
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
    # The first of four joints before an end without a number is the palm's bone; without that end,
    # or if it has a number, the fourth is the tip.
    "SOMA, Mixamo with tips": (
        "Hips LeftLeg LeftShin LeftFoot RightLeg RightShin RightFoot Chest LeftArm LeftForeArm"
        " LeftHand LeftHandIndex1 LeftHandIndex2 LeftHandIndex3 LeftHandIndex4 LeftHandIndexEnd"
        " LeftHandThumb1 LeftHandThumb2 LeftHandThumb3 LeftHandThumbEnd"
        " RightArm RightForeArm RightHand"
        " RightHandRing1 RightHandRing2 RightHandRing3 RightHandRing4"
        " RightHandPinky1 RightHandPinky2 RightHandPinky3 RightHandPinky4 RightHandPinky4_end",
        [
            *(-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 9, 10, 11, 12, 13, 14, 10, 16, 17, 18),
            *(7, 20, 21, 22, 23, 24, 25, 22, 27, 28, 29, 30),
        ],
        {f"left_index{k}": f"LeftHandIndex{k + 1}" for k in (1, 2, 3)}
        | {f"left_thumb{k}": f"LeftHandThumb{k}" for k in (1, 2, 3)}
        | {f"right_ring{k}": f"RightHandRing{k}" for k in (1, 2, 3)}
        | {f"right_pinky{k}": f"RightHandPinky{k}" for k in (1, 2, 3)},
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
        for joint in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist"):
            assert names[found[JOINT_INDEX[f"{side}_{joint}"]]].lower().find(side[0]) >= 0
