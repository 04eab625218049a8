"""Limbs in the body: the verdict is that of the frames in which they are there."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.repair import limbs
from support.made_clips import standing
from support.real_clips import real_clip


def verdict(motion):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    done, left = [], []
    limbs.simulated([motion], scene, [hp.Body.default()], done, left)
    return done, left


@pytest.fixture(scope="module")
def squat():
    """Arms pass through thighs and trunk."""
    return hp.fix(real_clip("asap_squat3.npz")[:120]).motion


def test_caught_limbs_are_left_however_long_the_person_stands_before(squat):
    before = np.concatenate([np.zeros(500, dtype=int), np.arange(len(squat))])
    longer = squat.with_frames(squat.translation[before], squat.rotations[before])
    for motion in (squat, longer):
        done, left = verdict(motion)
        assert done == []
        assert any("would be caught" in line for line in left)


@pytest.mark.parametrize("after", [20, 300])
def test_a_limb_that_passes_for_a_moment_is_not_caught_for_as_long_as_it_stays(after):
    """The left arm swings through the trunk in 12 frames and stays behind the back."""
    ways = np.radians([-50.0] * 10 + np.linspace(-50.0, 50.0, 12).tolist() + [50.0] * after)
    motion = standing(len(ways))
    turns = motion.rotations.copy()
    down = rot.exp(np.array([0.0, 0.0, np.radians(-105.0)]))
    swing = rot.exp(np.stack([ways, 0.0 * ways, 0.0 * ways], axis=1))
    turns[:, JOINT_INDEX["left_shoulder"]] = rot.log(rot.multiply(swing, down))
    done, left = verdict(motion.with_frames(motion.translation, turns))
    assert done == []
    assert any("would be caught" in line for line in left)


def test_limbs_that_are_in_nothing_have_no_line():
    assert verdict(standing()) == ([], [])


def test_a_push_is_no_limb_in_the_body():
    """Somebody glides into a heavy crate: legs and trunk are moved, no limb was in the body."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    still = standing(60)
    place = hp.Body.default().joints(still)[0, 0]
    scene.add_object(
        "crate", hp.Box((2.0, 0.4, 0.9)), mass=500.0, position=(place[0], place[1] - 0.6, 0.45)
    )
    way = np.outer(np.minimum(np.arange(60) / 40.0, 1.0), [0.0, -0.5, 0.0])
    repair = hp.fix(still.with_frames(still.translation + way, still.rotations), scene, plant=False)
    assert not any("limbs" in line for line in repair.lines)


def test_frames_after_a_touch_belong_to_it():
    touching = np.zeros(60, dtype=bool)
    touching[[5, 40]] = True
    found = np.flatnonzero(limbs._with_after(touching, 30.0))
    assert np.array_equal(found, [*range(5, 15), *range(40, 50)])


def test_the_worst_second_counts():
    motion = standing(90)
    result = hp.simulate(motion, hp.Scene())
    other = hp.simulate(motion, hp.Scene())
    turns = np.array(other.people[0].motion.rotations)
    turns[30:60, 16, 2] += 0.5
    moved = other.people[0].motion.with_frames(other.people[0].motion.translation, turns)
    body = hp.Body.default()
    one = result.people[0]
    two = dataclasses.replace(other.people[0], motion=moved)
    every = np.ones(90, dtype=bool)
    expected = hp.metrics.mpjpe(one.motion[30:60], moved[30:60], body)
    assert abs(limbs._apart(one, two, every) - expected) < 1e-9
    assert limbs._apart(one, two, every & (np.arange(90) < 30)) == 0.0
