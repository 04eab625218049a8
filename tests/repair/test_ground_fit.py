"""The ground of a clip: height, tilt and drift are found where they are, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.repair.ground_fit import STANDS, fit_ground
from halfphysics.repair.soles import Soles

FPS = 30.0
#: Height [m], slope, drift [m/s] of a path of many steps, with noise of 2 mm, are met to this.
HEIGHT, SLOPE, DRIFT = 0.002, 0.002, 0.001


def walked(rise, *, turns=True, noise=0.002, seconds=8.0, seed=0):
    """Soles of somebody who walks a curve (or a line): each foot rests for 0.6 of 1 s in turn.

    `rise`: heights of the ground [m] at places (n, 2) and times (n,).
    """
    random = np.random.default_rng(seed)
    t = np.arange(round(seconds * FPS)) / FPS
    centre, rests = np.zeros((len(t), 4, 3)), np.zeros((len(t), 4), dtype=bool)
    for patch in range(4):
        phase = t + 0.5 * (patch // 2)
        step = np.floor(phase)
        angle = 0.8 * step if turns else 0.0 * step
        centre[:, patch, 0] = np.cos(angle) if turns else 0.7 * step
        centre[:, patch, 1] = np.sin(angle) if turns else 0.1 * (patch // 2)
        centre[:, patch, 0] += 0.2 * (patch % 2)
        rests[:, patch] = phase - step < 0.6
    gap = rise(centre[..., :2].reshape(-1, 2), np.repeat(t, 4)).reshape(-1, 4)
    gap = gap + STANDS + random.normal(0.0, noise, gap.shape)
    gap = gap + 0.2 * ~rests  # feet in the air say nothing
    centre[..., 2] = gap
    return Soles(centre, gap, gap, rests, FPS)


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
