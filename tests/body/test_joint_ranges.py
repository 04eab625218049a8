"""Ranges of joints: what the angles mean, where the ends are."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.joint_ranges import JointRanges, from_swing_twist, swing_twist
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES
from support.files.model_files import fields, write_npz

TWIST, FLEXION, ABDUCTION = range(3)
#: Joint, angle, a point that moves with it, and the direction that a positive turn takes the point.
MEANINGS = (
    ("left_elbow", FLEXION, "left_wrist", (0, 0, 1)),
    ("left_hip", FLEXION, "left_knee", (0, 0, 1)),
    ("left_hip", ABDUCTION, "left_knee", (-1, 0, 0)),
    ("left_knee", FLEXION, "left_ankle", (0, 0, -1)),
    ("left_ankle", FLEXION, "left_foot", (0, -1, 0)),
    ("left_shoulder", FLEXION, "left_elbow", (0, 0, 1)),
    ("left_shoulder", ABDUCTION, "left_elbow", (0, -1, 0)),
    ("left_wrist", FLEXION, "left_middle1", (0, -1, 0)),
    ("left_wrist", ABDUCTION, "left_middle1", (0, 0, -1)),
    ("left_index2", FLEXION, "left_index3", (0, -1, 0)),
    ("spine2", FLEXION, "neck", (0, 0, 1)),
)


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.fixture(scope="module")
def ranges(body):
    return JointRanges.of(body)


def test_axes_are_frames_and_ranges_hold_rest(ranges):
    np.testing.assert_allclose(
        ranges.axes @ ranges.axes.transpose(0, 2, 1), np.tile(np.eye(3), (55, 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(ranges.axes), 1.0)
    assert (ranges.lower <= 0.0).all()
    assert (ranges.upper >= 0.0).all()
    assert (ranges.upper - ranges.lower)[1:].max() < 2 * np.pi


@pytest.mark.parametrize(("joint", "angle", "end", "way"), MEANINGS)
def test_a_turn_about_an_axis_is_that_angle_and_goes_its_way(body, ranges, joint, angle, end, way):
    j = JOINT_INDEX[joint]
    turn = 0.7 * ranges.axes[j, angle]
    rotations = np.zeros((55, 3))
    rotations[j] = turn
    expected = np.zeros((55, 3))
    expected[j, angle] = 0.7
    np.testing.assert_allclose(ranges.angles(rotations), expected, atol=1e-12)
    arm = body.rest_joints[JOINT_INDEX[end]] - body.rest_joints[j]
    assert (rot.rotate(rot.exp(turn), arm) - arm) @ np.array(way) > 0.3 * np.linalg.norm(arm)


def test_left_and_right_are_mirror_images(ranges):
    rng = np.random.default_rng(0)
    for name in JOINT_NAMES:
        if name.startswith("left_"):
            turn = rng.normal(size=3)
            mirrored = turn * [1.0, -1.0, -1.0]
            left, right = JOINT_INDEX[name], JOINT_INDEX["right_" + name.removeprefix("left_")]
            np.testing.assert_allclose(
                swing_twist(rot.exp(turn), ranges.axes[left]),
                swing_twist(rot.exp(mirrored), ranges.axes[right]),
                atol=1e-12,
            )
            np.testing.assert_array_equal(ranges.lower[left], ranges.lower[right])


def test_a_twist_before_a_swing(ranges):
    """q = swing * twist, and the swing's components are those of its rotation vector's quarter
    tangent."""
    axes = ranges.axes[JOINT_INDEX["left_hip"]]
    swing = 1.9 * (0.6 * axes[1] + 0.8 * axes[2])
    q = rot.multiply(rot.exp(swing), rot.exp(-0.8 * axes[0]))
    quarter = np.tan(1.9 / 4)
    expected = [-0.8, 4 * np.arctan(0.6 * quarter), 4 * np.arctan(0.8 * quarter)]
    np.testing.assert_allclose(swing_twist(q, axes), expected, atol=1e-12)
    np.testing.assert_allclose(swing_twist(-q, axes), expected, atol=1e-12)


def test_angles_give_the_rotation_back(ranges):
    rng = np.random.default_rng(2)
    angles = rng.uniform(-2.0, 2.0, size=(50, 55, 3))
    angles[0] = 0.0
    turns = from_swing_twist(angles, ranges.axes)
    np.testing.assert_allclose(ranges.angles(turns), angles, atol=1e-9)


def test_the_whole_person_turns_as_far_as_it_likes(ranges):
    asked, own = np.zeros((5, 55, 3)), np.zeros((5, 55, 3))
    asked[:, 0, 1] = 3.0
    own[:, 0] = [[-3.1, 0, 0], [0, -3.1, 0], [0, 0, 3.1], [2, 2, 2], [0, 3.2, 0]]
    assert ranges.excess(own, asked).max() == 0.0


def test_what_the_reference_asks_is_no_excess(ranges):
    rng = np.random.default_rng(1)
    asked = rng.normal(size=(20, 55, 3))
    assert ranges.excess(asked, asked).max() == 0.0
    own = np.array(asked)
    j = JOINT_INDEX["left_knee"]
    own[0, j] = (np.radians(170.0), 0.0, 0.0)
    asked[0, j] = (np.radians(165.0), 0.0, 0.0)
    assert np.degrees(ranges.excess(own, asked)[0, j, FLEXION]) == pytest.approx(5.0)
    asked[0, j] = 0.0
    assert np.degrees(ranges.excess(own, asked)[0, j, FLEXION]) == pytest.approx(10.0)


def test_a_body_without_fingers_has_ranges(tmp_path):
    """SMPL's: its fingers are where the wrists are, and nothing is beyond at rest."""
    body = hp.Body.load(write_npz(tmp_path / "smpl.npz", fields("smpl", columns=10)))
    ranges = JointRanges.of(body)
    np.testing.assert_allclose(
        ranges.axes @ ranges.axes.swapaxes(1, 2), np.tile(np.eye(3), (55, 1, 1)), atol=1e-12
    )
    assert ranges.excess(np.zeros((55, 3)), np.zeros((55, 3))).max() == 0.0
