"""Rotations from joint positions: met, without flips, as the truth where positions tell it.

Positions are computed with rotation matrices of scipy (`support.files.position_files`).
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.formats.positions.bones import bones_of
from halfphysics.formats.positions.inverse_kinematics import solve
from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS
from support.files.layouts import movement
from support.files.position_files import STRANGER, offsets, places
from support.real_clips import NAMES, real_clip

MET = 1.5e-3  # metres, mean of a clip: the priors' pull
EXTRA = np.radians(60.0)
JUMP = np.radians(30.0)  # more than the truth turns between frames: a straight arm is thrown
BODY = range(22)
#: Joints without a joint below them: positions say nothing of their rotations.
ENDS = [JOINT_INDEX[j] for j in ("left_foot", "right_foot", "head", "left_wrist", "right_wrist")]
INNER = [j for j in BODY if j not in ENDS]
REST = np.asarray(hp.Body.default().rest_joints)


def seen(motion, bones=None):
    pelvis = motion.translation + motion.axes @ REST[0]
    return places(motion.rotations, pelvis, offsets(REST, 22) if bones is None else bones)


def angles(a, b):
    """Angles (T, J) between rotations (T, J, 3), by scipy."""
    one, other = (Rotation.from_rotvec(np.array(x).reshape(-1, 3)) for x in (a, b))
    return (one.inv() * other).magnitude().reshape(a.shape[:2])


def check(motion):
    """Positions are met, and no joint turns or jumps by much more than the truth."""
    positions = seen(motion)
    solved = solve(positions, BODY, REST)
    again = places(solved.rotations, solved.pelvis, offsets(REST, 22))
    errors = np.linalg.norm(again - positions, axis=2)
    assert errors.mean() < MET
    assert np.abs(errors - solved.errors).max() < 1e-9
    zero = np.zeros_like(motion.rotations[:, BODY])
    own = solved.rotations[:, BODY]
    truth = motion.rotations[:, BODY]
    assert (angles(own, zero) - angles(truth, zero))[:, 1:].max() < EXTRA
    steps = angles(own[1:], own[:-1]) - angles(truth[1:], truth[:-1])
    assert steps[:, INNER].max() < JUMP
    assert not own[:, ENDS].any()


@pytest.mark.filterwarnings("ignore::halfphysics.HalfPhysicsWarning")
@pytest.mark.parametrize("name", NAMES)
def test_recorded_clips(name):
    check(real_clip(name))


@pytest.mark.parametrize(
    "name", ["climb_onto_bed", "crawl_under_table", "kick_ball", "sit_on_sofa"]
)
def test_authored_clips(name):
    check(scenarios.load(name).motions[0])


def test_hinges_are_found_exactly():
    """Knees and elbows that only flex, on hips and shoulders that turn about all axes."""
    motion = hp.Motion(*movement(90), 60.0)
    rotations = np.zeros_like(motion.rotations)
    rotations[:, 0] = motion.rotations[:, 0]
    rotations[:, :3] = motion.rotations[:, :3]
    flexed = 0.9 + 0.4 * np.sin(np.arange(90) / 9.0)
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[:, JOINT_INDEX[f"{side}_knee"], 0] = flexed
        rotations[:, JOINT_INDEX[f"{side}_elbow"], 1] = sign * flexed
        rotations[:, JOINT_INDEX[f"{side}_shoulder"], 2] = sign * 0.9
    truth = hp.Motion(motion.translation, rotations, 60.0)
    solved = solve(seen(truth), BODY, REST)
    off = angles(solved.rotations[:, BODY], rotations[:, BODY])
    # What is left: ankles, collars and shoulders share turns that positions do not tell apart.
    assert np.degrees(off[:, [1, 2, 4, 5, 18, 19]].max()) < 6.0
    assert np.degrees(off[:, [0, 3, 6, 9]].max()) < 3.0


def test_a_straight_limb_that_bends_does_not_flip():
    """An arm goes slowly from a little over-stretched to bent: the upper arm hardly turns."""
    frames = 80
    rotations = np.zeros((frames, 55, 3))
    rotations[:, JOINT_INDEX["left_elbow"], 1] = -np.linspace(-0.05, 1.2, frames)
    rotations[:, JOINT_INDEX["right_knee"], 0] = np.linspace(-0.05, 1.2, frames)
    positions = places(rotations, np.zeros((frames, 3)), offsets(REST, 22))
    solved = solve(positions, BODY, REST)
    steps = angles(solved.rotations[1:, BODY], solved.rotations[:-1, BODY])
    assert np.degrees(steps.max()) < 3.0


def test_a_strangers_skeleton():
    """Bones of another form are found, and joints on them are met."""
    rest = np.array(REST)
    for joint in BODY:
        rest[joint] = STRANGER[joint] + (rest[PARENTS[joint]] if joint else 0.0)
    translation, rotations = movement(60)
    positions = np.full((60, 55, 3), np.nan)
    positions[:, :22] = places(rotations, translation, STRANGER)
    bones = bones_of(positions, REST)
    assert np.isnan(bones[22:]).all()
    lengths = np.linalg.norm(STRANGER[1:], axis=1)
    assert np.abs(np.linalg.norm(bones[1:22], axis=1) - lengths).max() < 1e-9
    # Pelvis and chest keep their form: distances between the ends of their bones.
    for a, b in ((1, 2), (1, 3), (2, 3), (12, 13), (12, 14), (13, 14)):
        expected = np.linalg.norm(STRANGER[a] - STRANGER[b])
        assert abs(np.linalg.norm(bones[a] - bones[b]) - expected) < 1e-9
    body = hp.Body.default(bones=bones)
    solved = solve(positions[:, :22], BODY, np.asarray(body.rest_joints))
    again = places(solved.rotations, solved.pelvis, offsets(np.asarray(body.rest_joints), 22))
    assert np.linalg.norm(again - positions[:, :22], axis=2).mean() < MET


def test_turning_the_world_turns_the_pelvis_alone():
    motion = hp.Motion(*movement(20), 60.0)
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0])
    one = solve(seen(motion), BODY, REST)
    other = solve(turn.apply(seen(motion).reshape(-1, 3)).reshape(20, 22, 3), BODY, REST)
    assert np.abs(one.rotations[:, 1:] - other.rotations[:, 1:]).max() < 1e-7
    assert np.abs(turn.apply(one.pelvis) - other.pelvis).max() < 1e-9


def test_a_thousand_frames_take_about_a_second():
    positions = seen(hp.Motion(*movement(1000), 60.0))
    start = time.process_time()
    solve(positions, BODY, REST)
    assert time.process_time() - start < 3.0  # 0.3 s on a machine that is not busy
