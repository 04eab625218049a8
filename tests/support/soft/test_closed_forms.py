"""The closed forms agree with each other and with the textbook's limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from support.soft import closed_forms as forms


def test_forces_are_k_times_the_volume_below_the_surface():
    k, radius, length, depth = 1e5, 0.2, 0.5, 0.03
    reach = np.sqrt(2 * radius * depth - depth**2)

    def below(r):
        return depth - radius + np.sqrt(radius**2 - r**2)

    ring = quad(lambda r: 2.0 * np.pi * r * k * below(r), 0.0, reach)[0]
    strip = quad(lambda x: k * length * below(x), -reach, reach)[0]
    assert forms.ball_force(k, radius, depth) == pytest.approx(ring, rel=1e-9)
    assert forms.cylinder_force(k, radius, length, depth) == pytest.approx(strip, rel=1e-7)


def test_limits_at_small_depth():
    k, radius, length, depth = 1e5, 0.2, 0.5, 1e-5
    ball = np.pi * k * radius * depth**2
    lying = 4.0 / 3.0 * k * length * np.sqrt(2.0 * radius) * depth**1.5
    assert forms.ball_force(k, radius, depth) == pytest.approx(ball, rel=1e-4)
    assert forms.cylinder_force(k, radius, length, depth) == pytest.approx(lying, rel=1e-3)


def test_settling_solves_its_equation():
    k, c, area, mass = 2e4, 2e3, 0.16, 10.0
    t = np.linspace(0.0, 1.0, 101)

    def rates(_, y):
        return [y[1], forms.G - area * (k * y[0] + c * y[1]) / mass]

    done = solve_ivp(rates, (0.0, 1.0), [0.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(forms.settling(k, c, area, mass, t), done.y[0], atol=1e-9)


def test_a_landing_takes_as_long_and_goes_as_deep_as_its_equation():
    k, area, mass, speed = 2e4, 0.16, 10.0, 2.0

    def rates(_, y):
        return [y[1], forms.G - area * k * y[0] / mass]

    def left(t, y):
        return y[0] if t > 1e-3 else 1.0

    left.terminal, left.direction = True, -1
    done = solve_ivp(rates, (0.0, 1.0), [0.0, speed], events=left, rtol=1e-10, atol=1e-12)
    assert forms.contact_time(k, area, mass, speed) == pytest.approx(done.t[-1], rel=1e-6)
    deepest = forms.deepest(k, area, mass, speed)
    t = np.linspace(0.0, done.t[-1], 2001)
    fine = solve_ivp(rates, (0.0, done.t[-1]), [0.0, speed], t_eval=t, rtol=1e-10, atol=1e-12)
    assert deepest == pytest.approx(fine.y[0].max(), rel=1e-5)


def test_peaks_of_a_damped_swing():
    t = np.linspace(0.0, 3.0, 301)
    at, _ = forms.peaks(t, np.exp(-0.5 * t) * np.cos(8.0 * t + 1.0))
    assert np.diff(at) == pytest.approx(2.0 * np.pi / 8.0, rel=1e-3)
