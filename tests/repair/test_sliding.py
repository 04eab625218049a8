"""The slide that all resting soles have in common."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.repair.sliding import common_slide, without_slide
from halfphysics.repair.soles import Soles
from support.walked_soles import FPS, walked

#: Velocity is met to this [m/s].
SPEED = 1e-3


def slid(velocity, noise=0.0):
    soles = walked(lambda p, t: 0.0 * t)
    time = np.arange(len(soles.centre)) / FPS
    centre = soles.centre + time[:, None, None] * np.array([*velocity, 0.0])
    centre = centre + np.random.default_rng(2).normal(0.0, noise, centre.shape)
    return Soles(centre, soles.lowest, soles.gap, soles.rests, FPS)


def test_feet_that_stand_do_not_slide():
    assert not common_slide([slid((0.0, 0.0))]).any()
    assert not common_slide([slid((0.0, 0.0), noise=0.003)]).any()


def test_a_common_velocity_is_found():
    found = common_slide([slid((0.08, -0.06), noise=0.002)])
    assert np.abs(found - [0.08, -0.06]).max() < 5.0 * SPEED
    assert np.abs(common_slide([slid((0.08, -0.06))]) - [0.08, -0.06]).max() < SPEED


def test_feet_that_slide_each_their_own_way_have_nothing_in_common():
    soles = slid((0.0, 0.0))
    time = np.arange(len(soles.centre)) / FPS
    centre = soles.centre.copy()
    for patch, way in enumerate([(0.1, 0.0), (0.1, 0.0), (-0.1, 0.0), (-0.1, 0.0)]):
        centre[:, patch, :2] += time[:, None] * np.array(way)
    assert not common_slide([Soles(centre, soles.lowest, soles.gap, soles.rests, FPS)]).any()


def test_it_comes_off_from_the_first_frame_on():
    motion = hp.Motion(np.ones((31, 3)), np.zeros((31, 55, 3)), 30.0)
    made = without_slide(motion, np.array([0.3, 0.1]))
    assert made.translation[0].tolist() == [1.0, 1.0, 1.0]
    assert np.allclose(made.translation[30], [0.7, 0.9, 1.0], atol=1e-12)
