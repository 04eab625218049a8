"""A foot that rests flat: noise goes, a roll stays, the rest is not touched."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from halfphysics.repair.steadied import MOST, WINDOW, steadied

FPS = 30.0


def quaternions(turns):
    """Scalar first (T, 4)."""
    return np.roll(turns.as_quat(), 1, axis=1)


def off(a, b):
    """Angles between quaternions (T,) [rad]."""
    first, second = (Rotation.from_quat(np.roll(q, -1, axis=1)) for q in (a, b))
    return (first * second.inv()).magnitude()


def rolling(frames=60):
    """A foot that rolls, faster and faster, to 20 degrees."""
    t = np.linspace(0.0, 1.0, frames)
    return Rotation.from_rotvec(np.outer(np.deg2rad(20.0) * t**2, [0.6, 0.8, 0.0]))


def test_noise_falls_to_a_half():
    random = np.random.default_rng(3)
    true = Rotation.from_euler("z", 40.0, degrees=True)
    noise = Rotation.from_rotvec(random.normal(0.0, 0.01, (90, 3)))
    bad = quaternions(noise * true)
    made = steadied(bad, np.ones(90, dtype=bool), FPS)
    clean = quaternions(Rotation.concatenate([true] * 90))
    assert off(made, clean).mean() < 0.55 * off(bad, clean).mean()


def test_a_roll_stays_as_it_is():
    # Quadratic in time about one axis; quaternions of it differ from quadratics by the third order.
    asked = quaternions(rolling())
    made = steadied(asked, np.ones(60, dtype=bool), FPS)
    assert off(made, asked).max() < np.deg2rad(0.02)


def test_only_flat_frames_turn_and_signs_do_not_matter():
    random = np.random.default_rng(3)
    noise = Rotation.from_rotvec(random.normal(0.0, 0.01, (60, 3)))
    bad = quaternions(noise * rolling())
    flat = np.zeros(60, dtype=bool)
    flat[20:45] = True
    made = steadied(bad, flat, FPS)
    assert np.array_equal(made[~flat], bad[~flat])
    assert off(made, bad)[flat].max() > 1e-3
    signs = np.where(np.arange(60) % 2, 1.0, -1.0)[:, None]
    assert off(steadied(signs * bad, flat, FPS), made).max() < 1e-7


def test_a_turn_is_bounded_and_a_short_rest_is_left():
    angle = np.where(np.arange(40) == 20, np.deg2rad(30.0), 0.0)
    bad = quaternions(Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])))
    made = steadied(bad, np.ones(40, dtype=bool), FPS)
    assert off(made, bad).max() < MOST + 1e-9
    short = np.zeros(40, dtype=bool)
    short[18:22] = True
    assert len(bad) > WINDOW * FPS
    assert np.array_equal(steadied(bad, short, FPS), bad)
