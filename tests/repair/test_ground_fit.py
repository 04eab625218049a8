"""The ground of a clip: height, tilt and drift are found where they are, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.repair.ground_fit import fit_ground
from halfphysics.repair.soles import Soles
from support.walked_soles import FPS, walked

#: Height [m], slope, drift [m/s] of a path of many steps, with noise of 2 mm, are met to this.
HEIGHT, SLOPE, DRIFT = 0.002, 0.002, 0.001


def test_level_ground_needs_nothing():
    ground = fit_ground([walked(lambda p, t: 0.0 * t)])
    assert ground.level
    assert ground.spread < 0.01


@pytest.mark.parametrize("height", [-0.5, -0.03, 0.05])
def test_height(height):
    ground = fit_ground([walked(lambda p, t: height + 0.0 * t)])
    assert abs(ground.height - height) < HEIGHT
    assert ground.tilt == ground.drift == 0.0


def test_drift_on_a_line():
    ground = fit_ground([walked(lambda p, t: -0.02 * t, turns=False)])
    assert abs(ground.drift + 0.02) < DRIFT
    assert ground.tilt == 0.0
    assert abs(ground.height + 0.02 * ground.time) < HEIGHT


def test_tilt_of_a_path_that_turns():
    slope = np.array([0.03, -0.02])
    ground = fit_ground([walked(lambda p, t: p @ slope)])
    assert np.abs(np.array(ground.slope) - slope).max() < SLOPE
    assert ground.drift == 0.0
    assert abs(ground.tilt - np.arctan(np.hypot(*slope))) < SLOPE


def test_tilt_and_drift_at_once():
    slope = np.array([0.03, 0.02])
    ground = fit_ground([walked(lambda p, t: p @ slope + 0.03 * t, seconds=14.0)])
    assert np.abs(np.array(ground.slope) - slope).max() < SLOPE
    assert abs(ground.drift - 0.03) < DRIFT


def test_toes_lower_than_heels_are_no_tilt():
    soles = walked(lambda p, t: 0.0 * t, turns=False)
    gap = soles.gap + np.array([0.004, -0.004, 0.004, -0.004])
    ground = fit_ground([Soles(soles.centre, soles.lowest, gap, soles.rests, FPS)])
    assert ground.tilt == ground.drift == 0.0


def test_a_foot_on_a_step_does_not_lift_the_ground():
    soles = walked(lambda p, t: np.where(p[:, 1] > 0.9, 0.12, 0.0))
    assert fit_ground([soles]).level


def test_a_ramp_is_no_damage():
    ground = fit_ground([walked(lambda p, t: 0.5 * p[:, 0], turns=True)])
    assert ground.tilt == 0.0


def test_two_people_share_a_ground():
    still = walked(lambda p, t: 0.04 + 0.0 * t, seconds=1.0)
    many = walked(lambda p, t: 0.04 + 0.0 * t, seed=1)
    assert abs(fit_ground([still, many]).height - 0.04) < HEIGHT


def test_no_rest_no_ground():
    soles = walked(lambda p, t: 0.0 * t)
    none = Soles(soles.centre, soles.lowest, soles.gap, np.zeros_like(soles.rests), FPS)
    assert fit_ground([none]) is None
