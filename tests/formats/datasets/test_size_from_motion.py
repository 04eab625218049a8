"""The size of a person from planted feet and from hands at moving things."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats.datasets.size_from_motion import body_by_motion
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import ObjectTrack
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from support.carries.people import person

FPS, EXACT = 30.0, 1e-6
#: Of joints, with hands that slide by 2 mm on what they hold [m].
NEAR = 5e-3


def found(motion, tracks=None):
    """The body, and what was said."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", HalfPhysicsWarning)
        body = body_by_motion("clip.npz: nothing says it", motion, tracks)
    (message,) = said
    return body, str(message.message)


def carrying(body, slide=0.0, frames=60):
    """Standing still, the right elbow bends with a thing in the hand."""
    t = np.arange(frames) / FPS
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    rotations[:, JOINT_INDEX["right_elbow"], 1] = 0.8 - 0.7 * np.cos(2.0 * t)
    rotations[:, JOINT_INDEX["right_shoulder"], 2] = 0.5 * np.sin(2.0 * t)
    motion = hp.Motion(np.zeros((frames, 3)), rotations, FPS)
    places, turns = body.joint_frames(motion)
    wrist = JOINT_INDEX["right_wrist"]
    away = np.array([-0.12, 0.03, 0.0]) + slide * np.sin(2.0 * t + 1.0)[:, None] * [0.0, 0.0, 1.0]
    place = places[:, wrist] + rot.rotate(turns[:, wrist], away)
    return motion, {"thing": ObjectTrack(position=place, quaternion=turns[:, wrist])}


@pytest.mark.parametrize("stature", [1.55, 1.75, 1.95])
def test_planted_feet_tell_the_stature(stature):
    body = person(stature)
    motion = walk(body, Walk(distance=1.5, speed=0.8, before=0.5, after=0.5), FPS)
    got, said = found(motion)
    assert f"nothing says it: planted feet tell {stature:.2f} m" in said
    assert np.abs(got.joints(motion) - body.joints(motion)).max() < EXACT


@pytest.mark.parametrize("arms", [0.9, 1.1])
@pytest.mark.parametrize("slide", [0.0, 0.002])
def test_hands_on_things_tell_the_arms(arms, slide):
    body = person(1.7, arms)
    step = walk(body, Walk(distance=1.0, speed=0.8, before=0.5, after=0.5), FPS)
    motion, tracks = carrying(body, slide)
    whole = step.with_frames(
        np.concatenate([step.translation, motion.translation]),
        np.concatenate([step.rotations, motion.rotations]),
    )
    track = tracks["thing"]
    before = len(step)
    rest = ObjectTrack(
        position=np.concatenate([np.repeat(track.position[:1], before, 0), track.position]),
        quaternion=np.concatenate([np.repeat(track.quaternion[:1], before, 0), track.quaternion]),
    )
    got, said = found(whole, {"thing": rest})
    assert "hands on what they move arms of" in said
    assert np.abs(got.joints(motion) - body.joints(motion)).max() < (NEAR if slide else 1e-3)


def test_of_who_stands_still_a_hand_tells_the_stature():
    body = person(1.9)
    motion, tracks = carrying(body)
    got, said = found(motion, tracks)
    assert "hands on what they move tell 1.9" in said
    assert np.abs(got.joints(motion) - body.joints(motion)).max() < NEAR


def test_nothing_is_told_by_who_does_not_move():
    rotations = np.zeros((30, 55, 3))
    got, said = found(hp.Motion(np.zeros((30, 3)), rotations, FPS))
    assert got is None
    assert "Body.default() is taken" in said


def test_a_hand_that_passes_a_moving_thing_tells_nothing():
    """The arms stay as they are where no hand goes with the thing."""
    body = person(1.7)
    motion = walk(body, Walk(distance=1.5, speed=0.8, before=0.5, after=0.5), FPS)
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(motion), 1))
    along = np.linspace([0.0, 2.0, 1.0], [0.0, -2.0, 1.0], len(motion))
    got, _ = found(motion, {"ball": ObjectTrack(position=along, quaternion=still)})
    assert np.abs(got.joints(motion) - body.joints(motion)).max() < NEAR
