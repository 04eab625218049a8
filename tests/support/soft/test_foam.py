"""The integrator of a block on foam against what can be written down."""

from __future__ import annotations

import numpy as np
import pytest

from support.soft import closed_forms as forms
from support.soft import foam

AREA, MASS = 0.04, 4.0
LINEAR = foam.Foam(4e4, 800.0, 0.1, 0.0, 0.0, 1.0)


def test_without_densification_and_arm_it_is_linear():
    times = np.linspace(0.0, 1.0, 51)
    depth, *_ = foam.press(LINEAR, MASS, AREA, 0.0, 0.0, times)
    expected = forms.settling(4e4, 800.0, AREA, MASS, times)
    np.testing.assert_allclose(depth, expected, atol=1e-6)


def test_it_creeps():
    """Long after the swing has gone, the depth is that of a spring and a Maxwell arm."""
    times = np.linspace(0.0, 14.0, 15)
    light = foam.Foam(4e4, 800.0, 0.1, 0.0, 0.5, 2.0)
    depth, *_ = foam.press(light, MASS, AREA, 0.0, 0.0, times)
    pressure = MASS * foam.G / AREA
    np.testing.assert_allclose(depth[3:], foam.creep(light, pressure, times[3:]), rtol=0.01)
    assert foam.creep(light, pressure, np.zeros(1))[0] == pytest.approx(pressure / 4e4 / 1.5)


def test_the_energy_of_a_rebound_is_what_the_work_has_left():
    """A rebound has the energy of the fall, less the work done on the foam."""
    times = np.linspace(0.0, 0.5, 2001)
    one = foam.Foam(4e4, 200.0, 0.1, 4.0, 0.5, 0.1)
    depth, rate, _, work = foam.press(one, MASS, AREA, -0.2, 0.0, times)
    energy = 0.5 * MASS * rate**2 - MASS * foam.G * depth
    np.testing.assert_allclose(energy + work, energy[0], atol=1e-4)
    assert work[-1] > 0.2 * energy[0]
    assert depth.max() < 0.1 < 1.3 * depth.max()
