"""The skin's own quadrature against a ball's closed form."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from support.soft import closed_forms as forms
from support.soft.skin_pressure import pressed

EVERYWHERE = np.array([[-9.0, -9.0], [9.0, 9.0]])


def test_a_ball():
    ball = trimesh.creation.icosphere(5, 0.2)
    depth, k = 0.05, 1e5
    vertices = np.add(ball.vertices, (0.3, 0.1, 0.2 - depth))
    found = pressed(vertices, ball.faces, 0.0, EVERYWHERE, k)
    assert found.load == pytest.approx(forms.ball_force(k, 0.2, depth), rel=0.01)
    assert found.peak == pytest.approx(k * depth, rel=0.01)
    assert found.area == pytest.approx(np.pi * (0.4 * depth - depth**2), rel=0.02)
    np.testing.assert_allclose(found.centre, [0.3, 0.1], atol=1e-3)
    half = pressed(vertices, ball.faces, 0.0, np.array([[0.3, -9.0], [9.0, 9.0]]), k)
    assert half.load == pytest.approx(0.5 * found.load, rel=0.02)
    high = pressed(vertices, ball.faces, 0.0, EVERYWHERE, k, least=0.5 * k * depth)
    assert 0.0 < high.area < found.area
