"""Colours of pressure: they get darker, and scales end on round numbers."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.render.pressure_colors import RAMP, scale_end, shades


def test_more_pressure_is_darker():
    colors = shades(np.linspace(0.0, 1.0, 50))
    grey = colors @ (0.2126, 0.7152, 0.0722)
    assert (np.diff(grey) < 0.0).all()


def test_the_ends_are_those_of_the_ramp_and_hold_outside():
    np.testing.assert_allclose(shades([0.0, -3.0]), [RAMP[0]] * 2)
    np.testing.assert_allclose(shades([[1.0, 7.0]]), [[RAMP[-1]] * 2])


@pytest.mark.parametrize(
    ("most", "end"), [(0.0, 1.0), (0.9, 1.0), (2.5, 3.0), (10.0, 10.0), (11.0, 15.0), (0.034, 0.04)]
)
def test_scales_end_on_round_numbers_not_below(most, end):
    assert scale_end(most) == pytest.approx(end)
