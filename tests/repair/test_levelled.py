"""A clip put on its ground: the inverse of what was done to it."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.repair.ground_fit import Ground
from halfphysics.repair.levelled import levelled
from support.damage import drifting, floating, tilted

#: Positions agree to this [m]: rounding of rotations that are composed.
EXACT = 1e-9


def motion():
    random = np.random.default_rng(5)
    places = random.normal(0.0, 1.0, (20, 3)) * 0.1
    return hp.Motion(places, random.normal(0.0, 0.3, (20, 55, 3)), 30.0)


def ground(**known):
    base = {"height": 0.0, "slope": (0.0, 0.0), "drift": 0.0, "centre": np.zeros(3), "time": 0.0}
    return Ground(**{**base, **known}, spread=0.0)


def test_height_and_drift_come_off():
    body, asked = hp.Body.default(), motion()
    bad = floating(drifting(asked, body), body)
    made = levelled(bad, body, ground(height=0.05, drift=-0.02))
    assert np.abs(body.joints(made) - body.joints(asked)).max() < EXACT


def test_a_tilt_is_turned_back_about_where_the_person_stands():
    body, asked = hp.Body.default(), motion()
    bad = tilted(asked, body, 3.0)
    # The ground z = 0 became n . x = 0.
    axis = np.array([0.8, 0.6, 0.0])
    normal = np.cos(np.deg2rad(3.0)) * np.array([0.0, 0.0, 1.0])
    normal = normal + np.sin(np.deg2rad(3.0)) * np.cross(axis, [0.0, 0.0, 1.0])
    slope = tuple(-normal[:2] / normal[2])
    made = levelled(bad, body, ground(slope=slope))
    assert np.abs(body.joints(made) - body.joints(asked)).max() < EXACT


def test_a_level_ground_changes_nothing():
    asked = motion()
    made = levelled(asked, hp.Body.default(), ground())
    assert np.array_equal(made.translation, asked.translation)
    assert np.array_equal(made.rotations, asked.rotations)
