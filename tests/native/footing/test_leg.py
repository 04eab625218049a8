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


@pytest.fixture
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


@pytest.mark.usefixtures("starts_in_the_step")
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


@pytest.mark.usefixtures("starts_in_the_step")
def test_a_leg_bends_about_its_own_axis():
    motion = squatting(BODY, hip=0.5, knee=1.0, ankle=0.5)
    result = hp.simulate(motion, step_under_left_foot(motion, 0.1), body=BODY)
    # Hips come up as far as the step; the leg beside it straightens by that.
    knee = result.motion.rotations[-1, hp.JOINT_NAMES.index("right_knee")]
    assert 0.0 < knee[0] < 0.9
    assert np.abs(knee[1:]).max() < np.radians(0.1)


@pytest.mark.filterwarnings("ignore:.*inside step")
@pytest.mark.parametrize("aside", [-9.5, -8.6, 8.6])
@pytest.mark.parametrize("height", [0.1, 0.14])
def test_a_knee_that_turns_aside_as_far_as_it_can_still_bends(height, aside):
    """Bent about the thigh's axis alone its turn aside passes its range, by 2 degrees.

    None of the lift was made then: the foot stayed in the step, and the person stood on it 0.2 m
    up with the other foot in the air.
    """
    frames = 60
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for joint, turn in (
            ("hip", [-16.4, 0.0, 3.6 * sign]),
            ("knee", [28.8, 0.0, aside * sign]),
            ("ankle", [-12.4, 0.0, -(3.6 + aside) * sign]),
        ):
            rotations[:, hp.JOINT_NAMES.index(f"{side}_{joint}")] = np.radians(turn)
    motion = hp.Motion(np.zeros((frames, 3)), rotations, 30.0).grounded(BODY, z=0.0)
    result = hp.simulate(motion, step_under_left_foot(motion, height), body=BODY)
    for sole, ground in zip(soles(result.motion), (height, 0.0), strict=True):
        assert STANDS[0] < sole - ground < STANDS[1]
    assert not result.contacts.impulse.any()
    assert range_violations(result, 0).max_deg < 0.1
