"""Acting: pelvis, hands and feet reach their targets, at the right times."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.acting import LIFT, Act
from halfphysics.scenarios.props.furniture import cushion


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.fixture
def act(body):
    return Act(body)


def joint(body, motion, name):
    return body.joints(motion)[:, JOINT_INDEX[name]]


@pytest.mark.parametrize("stature", [1.5, 1.95])
def test_it_begins_standing_on_the_floor(stature):
    body = Body.default(stature=stature)
    motion = Act(body).motion(0.1, 30.0)
    height = body.vertices(motion)[..., 2]
    assert abs(height.min() - LIFT) < 1e-4
    # The pelvis is slightly lowered so that both feet reach the ground: nearly straight knees.
    assert np.abs(motion.rotations[:, JOINT_INDEX["left_knee"], 0]).max() < np.radians(30.0)


def test_hands_and_feet_go_where_they_are_asked_to(body, act):
    hand, foot = np.array([0.38, 0.25, 1.3]), np.array([0.25, 0.13, 0.35])
    act.begin(**act.both(palm=(0.0, 1.0, 0.0), fingers=(1.0, 0.0, 0.3)))
    act.move(0.1, 0.5, **act.both(hand=hand, hold=1.0))
    act.move(0.2, 0.6, left_foot=foot)
    motion = act.motion(1.0, 50.0)
    mirror = np.array([1.0, -1.0, 1.0])
    assert np.allclose(joint(body, motion, "left_wrist")[-1], hand, atol=1e-6)
    assert np.allclose(joint(body, motion, "right_wrist")[-1], hand * mirror, atol=1e-6)
    assert np.allclose(joint(body, motion, "left_ankle")[-1], foot, atol=1e-6)
    # Palms: fingers along the requested direction, their backs outward.
    turns = body.joint_frames(motion)[1]
    for side, y in (("left", 1.0), ("right", -1.0)):
        frame = rot.to_matrix(turns[-1, JOINT_INDEX[f"{side}_wrist"]])
        along = np.array([1.0, 0.0, 0.3]) / np.hypot(1.0, 0.3)
        assert np.allclose(frame @ [y, 0.0, 0.0], along, atol=1e-6)
        assert np.allclose(frame @ [0.0, 1.0, 0.0], [0.0, y, 0.0], atol=1e-6)


def test_moves_of_one_control_add_up_and_steps_return(body, act):
    start = act["pelvis"]
    act.move(0.0, 1.0, pelvis=start + np.array([0.2, 0.0, 0.0]))
    act.move(0.5, 1.0, pelvis=start + np.array([0.2, 0.1, 0.0]))
    act.lift("pelvis", 0.5, 0.5, (0.0, 0.0, -0.05))
    act.step("left", 0.2, 0.8, act["left_foot"] + np.array([0.2, 0.0, 0.0]), 0.1)
    motion = act.motion(1.6, 100.0)
    pelvis = joint(body, motion, "pelvis")
    assert np.allclose(pelvis[0], start, atol=1e-9)
    assert np.allclose(pelvis[-1], start + np.array([0.2, 0.1, 0.0]), atol=1e-9)
    assert np.isclose(pelvis[75, 2], start[2] - 0.05)
    # The motion starts and ends at rest, and the two in between are one movement.
    speed = np.linalg.norm(np.diff(pelvis, axis=0), axis=1) * 100.0
    assert speed[0] < 0.01
    assert speed[-1] < 1e-9
    assert speed[30:120].min() > 0.05
    ankle = joint(body, motion, "left_ankle")
    assert np.isclose(ankle[60, 2] - ankle[0, 2], 0.1, atol=0.01)
    assert np.allclose(ankle[-1, 2], ankle[0, 2], atol=0.01)


def test_what_is_out_of_reach_is_approached_without_a_snap(body, act):
    act.begin(left_hold=1.0, left_hand=(0.3, 0.2, 1.4))
    act.move(0.0, 1.0, left_hand=(1.5, 0.2, 1.4))
    fastest = []
    for fps in (240.0, 1920.0):
        motion = act.motion(1.0, fps)
        arm = [joint(body, motion, f"left_{n}") for n in ("shoulder", "elbow", "wrist")]
        reach = np.linalg.norm(arm[2] - arm[0], axis=1)
        longest = sum(np.linalg.norm(b - a, axis=1)[0] for a, b in itertools.pairwise(arm))
        assert 0.985 * longest < reach[-1] < longest
        elbow = np.linalg.norm(np.diff(arm[1], 2, axis=0), axis=1) * fps**2
        fastest.append(elbow.max())
    # An elbow that stops at once decelerates the faster the higher the sampling rate.
    assert fastest[1] < 1.5 * fastest[0]


def test_impossible_frame_rates_are_refused(act):
    with pytest.raises(InputError):
        act.motion(1.0, 0.0)


def test_a_cushion_is_closed_and_as_large_as_asked():
    mesh = cushion((1.4, 2.0, 0.24))
    assert mesh.closed
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (1.4, 2.0, 0.24), atol=1e-3)
