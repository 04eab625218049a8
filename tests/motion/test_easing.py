"""Easing: the polynomial of least jerk."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.motion.easing import ease


def test_ease_is_smooth():
    """Speed and acceleration vanish at both ends: 10 x^3 - 15 x^4 + 6 x^5."""
    x = np.linspace(-0.5, 1.5, 20001)
    y = ease(x)
    step = x[1] - x[0]
    assert y[0] == 0.0
    assert y[-1] == 1.0
    assert np.all(np.diff(y) >= 0.0)
    bends = np.diff(y, n=2) / step**2
    assert np.abs(bends[np.abs(x[1:-1]) < 1e-9]).max() < 0.02
    assert np.abs(bends).max() == pytest.approx(10.0 / np.sqrt(3.0), rel=1e-3)
