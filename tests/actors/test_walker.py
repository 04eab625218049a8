"""Walking by footholds: feet that stay, knees that bend, nothing abrupt."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors.foot import Foothold
from halfphysics.actors.walker import Walker
from support.acted import body, range_excess, slide, smooth, until_done

WALK = hp.actors.WalkTo((4.0, 1.0), heading=0.5)


@pytest.fixture(scope="module")
def walk():
    return until_done(hp.actors.Person(body(), goals=[WALK]))


def test_feet_that_stand_do_not_slide(walk):
    moved = slide(walk)
    assert len(moved) > 100, "feet are down"
    assert moved.max() < 0.002, "2 mm a frame"
    assert moved.mean() < 0.0002


def test_nothing_is_abrupt_and_joints_keep_their_ranges(walk):
    assert smooth(walk)
    assert range_excess(walk) < 1e-9


def test_it_is_a_walk(walk):
    """Knees bend in the swing, arms swing against legs, the pelvis rises and falls."""
    angle = np.linalg.norm(walk.rotations, axis=2)
    knee = hp.JOINT_NAMES.index("left_knee")
    going = slice(25, 80)
    assert np.degrees(angle[going, knee].max()) > 50.0
    assert np.degrees(angle[going, knee].min()) < 25.0
    positions = body().joints(walk)[going]
    ahead = np.array([math.cos(0.245), math.sin(0.245), 0.0])
    along = {
        name: (positions[:, hp.JOINT_NAMES.index(name)] - positions[:, 0]) @ ahead
        for name in ("left_ankle", "left_wrist")
    }
    assert np.corrcoef(along["left_ankle"], along["left_wrist"])[0, 1] < -0.7
    assert 0.02 < np.ptp(positions[:, 0, 2]) < 0.08


def test_a_step_begins_and_ends_at_rest():
    walker = Walker(body())
    to = walker.placed(Foothold(0.3, 0.0, 0.0), "left")
    walker.step("left", to, None, 0.6)
    heights = []
    while (ended := walker.advance(0.01)) is None:
        heights.append(walker.now().feet[0].ankle[2])
    walker.land(ended)
    assert not walker.stepping
    assert walker.hold("left") == to
    assert walker.centre.x == pytest.approx(0.15)
    assert max(heights) > walker.legs["left"].height + 0.03, "the foot is lifted"


def test_legs_reach_their_feet(walk):
    """Ankles are where steps put them: no leg is asked for more than its length."""
    person = hp.actors.Person(body(), goals=[WALK])
    person.reset()
    for _ in range(120):
        pose = person.next(1.0 / 30.0, hp.actors.Seen())
        stand = person._walker.now()
        joints = body().joint_frames(pose)[0]
        for foot, name in zip(stand.feet, ("left_ankle", "right_ankle"), strict=True):
            off = np.linalg.norm(joints[hp.JOINT_NAMES.index(name)] - foot.ankle)
            assert off < 1e-3


def test_small_and_tall_people_walk_too():
    for stature in (1.2, 1.95):
        own = hp.Body.default(stature=stature)
        motion = until_done(hp.actors.Person(own, goals=[hp.actors.WalkTo((2.0, 0.0))]))
        assert slide(motion, own).max() < 0.002
        assert range_excess(motion, own) < 1e-9
