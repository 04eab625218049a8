"""Planted feet put down: onto the floor where they are near it, as they were elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.repair.ground_fit import STANDS
from halfphysics.repair.settled import NONE, WHOLE, onto, settled
from halfphysics.repair.soles import Soles

#: Soles turn a little as the leg bends [m].
NEAR = 5e-4


def standing(frames=40):
    turns = np.zeros((frames, 55, 3))
    turns[:, 0, 0] = np.pi / 2
    for side in ("left", "right"):
        for joint, share in (("hip", -0.3), ("knee", 0.6), ("ankle", -0.3)):
            turns[:, hp.JOINT_NAMES.index(f"{side}_{joint}"), 0] = share
    return hp.Motion(np.zeros((frames, 3)), turns, 30.0).grounded(hp.Body.default(), STANDS)


def floor():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


def heights(motion):
    """Lowest skin of all (T,) [m]."""
    return hp.Body.default().vertices(motion)[..., 2].min(axis=1)


def test_feet_come_onto_the_floor_by_legs():
    body, high = hp.Body.default(), standing()
    way = 0.008 * np.sin(np.arange(40))[:, None] * [0.0, 0.0, 1.0]
    bad = high.with_frames(high.translation + way, high.rotations)
    held = np.ones((40, 2), dtype=bool)
    made = settled(bad, body, Soles.of(bad, body, floor()), held)
    assert np.abs(heights(bad) - STANDS).max() > 0.007
    assert np.abs(heights(made) - STANDS).max() < NEAR


def test_what_is_not_held_is_not_put_down():
    body, high = hp.Body.default(), standing()
    bad = high.with_frames(high.translation + np.array([0.0, 0.0, 0.008]), high.rotations)
    made = settled(bad, body, Soles.of(bad, body, floor()), np.zeros((40, 2), dtype=bool))
    assert np.array_equal(made.rotations, bad.rotations)
    assert np.array_equal(made.translation, bad.translation)


@pytest.mark.parametrize("gap", [-0.04, NONE, 0.1, np.inf])
def test_a_foot_that_is_far_from_the_floor_is_left(gap):
    assert onto(np.array([gap]))[0] == 0.0


def test_the_farther_the_less():
    gap = np.linspace(-NONE, NONE, 121)
    shift = onto(gap)
    near = np.abs(gap) <= WHOLE
    assert np.abs((gap + shift)[near] - STANDS).max() < 1e-12
    # Nothing jumps: what is higher stays higher.
    assert (np.diff(gap + shift) > -2e-3).all()
    assert np.abs(np.diff(shift)).max() < 1.5e-3
