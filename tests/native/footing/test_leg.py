"""Legs that put a foot elsewhere: knees bend as knees do, joints stay within their ranges."""

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.metrics import range_violations
from support.squat import squatting

BODY = hp.Body.default()
SIDES = ("left", "right")
#: How high a sole is over what it stands on: clearance, gap and what its points miss [m].
STANDS = (0.0009, 0.007)


@pytest.fixture(autouse=True)
def starts_in_the_step():
    """The left foot starts in the step, and is put on it: that is what is looked at."""
    with pytest.warns(hp.HalfPhysicsWarning, match="inside step"):
        yield


def soles(motion):
    """Lowest point of each foot at the end [m]."""
    z = BODY.vertices(motion[-1])[:, 2]
    bone = BODY.weights.argmax(axis=1)
    parts = [[hp.JOINT_NAMES.index(f"{s}_{part}") for part in ("ankle", "foot")] for s in SIDES]
    return [z[np.isin(bone, foot)].min() for foot in parts]


def step_under_left_foot(motion, height):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    left = BODY.joints(motion[0])[hp.JOINT_NAMES.index("left_ankle")]
    middle = (left[0], left[1] - 0.1, height / 2.0)
    scene.add_static("step", hp.Box((0.2, 0.6, height)), position=middle)
    return scene


@pytest.mark.parametrize("height", [0.1, 0.15])
def test_an_ankle_at_the_end_of_its_range_lets_the_foot_tilt_instead(height):
    # The ankle is asked for 52 degrees: more than it has, and more still for a foot on a step.
    motion = squatting(BODY, hip=1.0, knee=1.6, ankle=0.9)
    scene = step_under_left_foot(motion, height)
    worst = {}
    for limits in (True, False):
        settings = hp.Settings(joint_limits=limits)
        result = hp.simulate(motion, scene, body=BODY, settings=settings)
        worst[limits] = range_violations(result, 0).max_deg
        for sole, ground in zip(soles(result.motion), (height, 0.0), strict=True):
            assert STANDS[0] < sole - ground < STANDS[1]
        assert not len(result.breaches)
    assert worst[True] < 0.1
    assert worst[False] > 5.0


def test_a_leg_bends_about_its_own_axis():
    motion = squatting(BODY, hip=0.5, knee=1.0, ankle=0.5)
    result = hp.simulate(motion, step_under_left_foot(motion, 0.1), body=BODY)
    # Hips come up as far as the step; the leg beside it straightens by that.
    knee = result.motion.rotations[-1, hp.JOINT_NAMES.index("right_knee")]
    assert 0.0 < knee[0] < 0.9
    assert np.abs(knee[1:]).max() < np.radians(0.1)
