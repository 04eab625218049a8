"""The camera shows the action in the part of the window beside the panel, and fills it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halfphysics.render.viewpoint import FOV
from halfphysics.viewer.framing import framed, free_part


def pixels(points, position, target, size):
    """Pixels of points in an upright camera, from the upper left corner."""
    ahead = (target - position) / np.linalg.norm(target - position)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    arm = points - position
    scale = 0.5 * size[1] / math.tan(math.radians(0.5 * FOV))
    depth = arm @ ahead
    assert (depth > 0.0).all()
    x = 0.5 * size[0] + scale * (arm @ right) / depth
    y = 0.5 * size[1] - scale * (arm @ up) / depth
    return x, y


@pytest.mark.parametrize("size", [(1280, 800), (390, 844), (1920, 500)])
@pytest.mark.parametrize("seed", range(5))
def test_all_points_are_in_the_free_part_and_fill_it_one_way(size, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(200, 3)) * rng.uniform(0.2, 3.0, size=3) + [3.0, -1.0, 1.0]
    angle = rng.uniform(0.0, 2.0 * np.pi)
    direction = np.array([math.cos(angle), math.sin(angle), 0.4])
    direction /= np.linalg.norm(direction)
    free = free_part(*size)
    camera = framed(points, direction, size)
    position, target = camera.position, camera.target
    np.testing.assert_allclose(
        (position - target) / np.linalg.norm(position - target), direction, atol=1e-9
    )
    x, y = pixels(points, position, target, size)
    assert 0.0 < x.min() < x.max() < free[0]
    assert 0.0 < y.min() < y.max() < free[1]
    assert max(np.ptp(x) / free[0], np.ptp(y) / free[1]) == pytest.approx(0.92, abs=1e-6)


def test_the_panel_is_on_the_right_of_a_wide_window_and_below_in_a_narrow_one():
    assert free_part(1280, 800) == (945, 800)
    assert free_part(390, 1000) == (390, 900)
    assert free_part(1170, 2000) == (1170, 1800)  # a phone with small pixels


def test_it_keeps_the_distance_that_is_asked_for():
    points = np.array([[1.0, 2.0, 3.0], [1.01, 2.0, 3.0]])
    camera = framed(points, np.array([0.0, 2.0, 1.0]), (1280, 800), distance=3.0)
    assert np.linalg.norm(camera.position - camera.target) == pytest.approx(3.0)
