"""Feet put elsewhere: where they should be, by legs and pelvis alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.repair.legs import MOST_DOWN, feet_moved

#: What the iteration leaves [m], [rad].
EXACT = 1e-4
ANKLES = [hp.JOINT_NAMES.index(f"{side}_ankle") for side in ("left", "right")]
LEGS = [
    hp.JOINT_NAMES.index(f"{side}_{joint}")
    for side in ("left", "right")
    for joint in ("hip", "knee", "ankle")
]


def standing(bend, frames=30):
    """Somebody who stands with both knees bent [rad]."""
    turns = np.zeros((frames, 55, 3))
    turns[:, 0, 0] = np.pi / 2
    for side in ("left", "right"):
        for joint, share in (("hip", -0.5), ("knee", 1.0), ("ankle", -0.5)):
            turns[:, hp.JOINT_NAMES.index(f"{side}_{joint}"), 0] = share * bend
    return hp.Motion(np.zeros((frames, 3)), turns, 30.0)


def asked(motion):
    """No shift, the rotations as they are, nobody has to stand."""
    turn = hp.Body.default().joint_frames(motion)[1][:, ANKLES]
    return np.zeros((len(motion), 2, 3)), turn, np.zeros((len(motion), 2), dtype=bool)


def test_an_ankle_goes_where_it_should_and_nothing_else_moves():
    body, motion = hp.Body.default(), standing(0.6)
    shift, turn, stands = asked(motion)
    shift[10:20, 0] = [0.02, -0.01, 0.015]
    made = feet_moved(motion, body, shift, turn, stands)
    way = body.joints(made)[:, ANKLES] - body.joints(motion)[:, ANKLES]
    assert np.abs(way - shift).max() < EXACT
    still = np.delete(np.arange(55), LEGS)
    assert np.array_equal(made.rotations[:, still], motion.rotations[:, still])
    assert np.array_equal(made.translation, motion.translation)
    outside = np.r_[0:10, 20:30]
    assert np.array_equal(made.rotations[outside], motion.rotations[outside])


def test_a_foot_turns_about_its_ankle():
    body, motion = hp.Body.default(), standing(0.6)
    shift, turn, stands = asked(motion)
    by = Rotation.from_rotvec([0.03, -0.02, 0.05])
    turn[:, 1] = np.roll((by * Rotation.from_quat(np.roll(turn[:, 1], -1, 1))).as_quat(), 1, 1)
    made = feet_moved(motion, body, shift, turn, stands)
    got = body.joint_frames(made)[1][:, ANKLES]
    off = np.abs((got * turn).sum(axis=2))
    assert np.arccos(np.minimum(off, 1.0)).max() < EXACT
    way = body.joints(made)[:, ANKLES] - body.joints(motion)[:, ANKLES]
    assert np.abs(way).max() < EXACT


@pytest.mark.parametrize("has_to", [True, False])
def test_a_straight_leg_reaches_lower_by_the_pelvis(has_to):
    body, motion = hp.Body.default(), standing(0.02)
    shift, turn, stands = asked(motion)
    shift[10:20, 0, 2] = -0.02
    stands[10:20, 0] = has_to
    made = feet_moved(motion, body, shift, turn, stands)
    way = body.joints(made)[:, ANKLES] - body.joints(motion)[:, ANKLES]
    down = motion.translation[:, 2] - made.translation[:, 2]
    if not has_to:
        assert np.abs(down).max() == 0.0
        assert np.abs(way[:, 0, 2]).max() < 0.001  # a straight leg is no longer than it is
        return
    assert np.abs(way - shift).max() < EXACT  # the other foot stays, too
    assert down[10:20].min() > 0.018
    assert down.max() < 0.0201
    assert np.abs(np.diff(down)).max() < 0.011  # it comes and goes
    assert not down[:5].any()


def test_the_pelvis_comes_down_by_so_much_at_most():
    body, motion = hp.Body.default(), standing(0.02)
    shift, turn, stands = asked(motion)
    shift[:, 0, 2], stands[:, 0] = -0.2, True
    made = feet_moved(motion, body, shift, turn, stands)
    down = motion.translation[:, 2] - made.translation[:, 2]
    assert np.abs(down - MOST_DOWN).max() < 1e-9
