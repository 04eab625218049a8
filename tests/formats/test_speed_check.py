"""Warnings of speeds that no person reaches."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, HalfPhysicsWarning
from halfphysics.formats import speed_check
from support.files.layouts import UPRIGHT, movement


def loaded(path, translation, rotations, fps=60.0):
    hp.Motion(translation, rotations, fps).save(path)
    return hp.Motion.load(path)


def test_a_plausible_motion_is_silent(tmp_path):
    translation, rotations = movement(60)
    motion = loaded(tmp_path / "a.npz", translation, rotations)
    joints = hp.Body.default().joints(motion)
    assert np.linalg.norm(np.diff(joints, axis=0), axis=2).max() * 60.0 < speed_check.JOINT_SPEED


def test_a_root_that_races_is_named(tmp_path):
    translation, rotations = movement(60)
    translation[31:] += [0.0, 0.25, 0.0]
    with pytest.warns(HalfPhysicsWarning, match=r"a\.npz: the root.*frames 30 and 31.*frames="):
        loaded(tmp_path / "a.npz", translation, rotations)


@pytest.mark.parametrize(
    ("turned", "seen"), [(18, "left_wrist"), (16, "left_wrist"), (2, "right_(foot|ankle)")]
)
def test_a_joint_that_flips_is_named(tmp_path, turned, seen):
    translation, rotations = movement(60)
    rotations[41:, turned] = [0.0, 0.0, 2.8]
    rotations[:41, turned] = 0.0
    with pytest.warns(HalfPhysicsWarning, match=rf"{seen} moves at .*frames 40 and 41"):
        motion = loaded(tmp_path / "a.npz", translation, rotations)
    # The message agrees with the skeleton.
    joints = hp.Body.default().joints(motion)[40:42]
    assert np.linalg.norm(joints[1] - joints[0], axis=1).max() * 60.0 > speed_check.JOINT_SPEED


@pytest.mark.parametrize(("arms", "legs"), [(0.0, 0.0), (0.8, 0.0), (1.57, 0.35)])
@pytest.mark.parametrize("root", [0.5, 3.0])
def test_a_rest_pose_before_the_clip_is_named(tmp_path, root, arms, legs):
    """A T-pose, an A-pose, or CMU's with legs 20 degrees apart, at the origin, and the clip
    elsewhere: a warning, or an error."""
    translation, rotations = movement(60)
    translation += [root, 0.0, 0.0]
    first = np.zeros((1, 55, 3))
    first[0, 0] = UPRIGHT["z"]
    first[0, [16, 17], 2] = -arms, arms
    first[0, [1, 2], 2] = legs, -legs
    first[0, [7, 8], 2] = -legs, legs
    path = tmp_path / "a.npz"
    poses = np.concatenate([first, rotations]).reshape(61, 165)
    places = np.concatenate([np.zeros((1, 3)), translation])
    np.savez(path, trans=places, poses=poses, fps=60.0, gender="male")
    way_out = r"Frame 0 is a rest pose \(a T-pose\).*frames=\(1, None\)"
    if root > 1.0:
        with pytest.raises(FileError, match=way_out):
            hp.Motion.load(path)
    else:
        with pytest.warns(HalfPhysicsWarning, match=way_out):
            hp.Motion.load(path)
    assert len(hp.Motion.load(path, frames=(1, None))) == 60  # and without a word


@pytest.mark.parametrize(("joint", "turn"), [(1, 0.5), (4, 0.5), (18, 0.5), (16, 0.5)])
def test_a_step_or_a_bent_limb_is_no_rest_pose(joint, turn):
    rotations = np.zeros((55, 3))
    assert speed_check.is_rest_pose(rotations)
    rotations[joint, 0] = turn
    assert not speed_check.is_rest_pose(rotations)


def test_a_rate_that_is_wrong_is_seen(tmp_path):
    translation, rotations = movement(60)
    hp.Motion(translation, rotations, 60.0).save(tmp_path / "a.smpl", body=hp.Body.default())
    with pytest.warns(HalfPhysicsWarning, match="fps= says another"):
        hp.Motion.load(tmp_path / "a.smpl", fps=1200.0)


def test_the_same_turn_spelled_otherwise_is_no_speed(tmp_path):
    translation, rotations = movement(60)
    # Beyond half a turn axis-angle has a shorter form; files have both.
    spin = rotations[:, 0].copy()
    length = np.linalg.norm(spin, axis=1, keepdims=True)
    other = spin * (1.0 - 2.0 * np.pi / length)
    rotations[30:, 0] = other[30:]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        loaded(tmp_path / "a.npz", translation, rotations)


def test_the_bound_is_above_all_speeds():
    body, rng = hp.Body.default(stature=2.2), np.random.default_rng(0)
    for seed in range(5):
        translation, rotations = movement(40, seed)
        rotations = rotations + np.cumsum(rng.normal(0, 0.1, rotations.shape), axis=0)
        motion = hp.Motion(translation, rotations, 60.0)
        step = np.linalg.norm(np.diff(translation, axis=0), axis=1) * 60.0
        joints = body.joints(motion)[:, :22]
        speed = np.linalg.norm(np.diff(joints, axis=0), axis=2).max(axis=1) * 60.0
        assert (speed <= speed_check._bounds(motion, step)).all()


def test_results_and_degrees_are_not_warned_of_twice(tmp_path):
    translation, rotations = movement(12)
    rotations[5:, 18] = [0.0, 0.0, 90.0]
    hp.Motion(translation, rotations, 30.0).save(tmp_path / "a.npz")
    with pytest.warns(HalfPhysicsWarning) as seen:
        hp.Motion.load(tmp_path / "a.npz")
    assert [("degrees" in str(w.message)) for w in seen] == [True]
