"""Surfaces of soft layers: they follow what presses, fade beside it, and stay over the frame."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.results.layer_surface import FADES, REACH, LayerSurface

THICK, SIZE = 0.12, np.array([1.0, 0.8, 0.3])
TOP = SIZE[2] / 2
UP = np.array([0.0, 0.0, 1.0])


def box():
    """The layer of a box with the twelve faces of its own shape."""
    surface, faces = hp.Box(SIZE).triangles()
    inner, _ = hp.Box(SIZE - 2 * THICK).triangles()
    return LayerSurface(
        surface=surface, inner=inner, faces=faces.astype(int), thickness=np.full(8, THICK)
    )


def flat(depth, half=(0.1, 0.3), pitch=0.015):
    """A flat stamp: its samples (n, 3) and their depths (n,)."""
    grids = [np.arange(-h, h + 1e-9, pitch) for h in half]
    xy = np.stack(np.meshgrid(*grids), axis=-1).reshape(-1, 2)
    return np.column_stack([xy, np.full(len(xy), TOP - depth)]), np.full(len(xy), depth)


def ball(radius, depth, pitch, at=(0.0, 0.0)):
    """Samples of a ball (n, 3), their depths (n,), and its centre."""
    centre = np.array([*at, TOP + radius - depth])
    grid = np.arange(-radius, radius, pitch)
    xy = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    xy = xy[(xy**2).sum(axis=1) < radius**2]
    z = centre[2] - np.sqrt(radius**2 - (xy**2).sum(axis=1))
    points = np.column_stack([xy + at, z])
    return points[z < TOP], TOP - z[z < TOP], centre


def pressed_by(points, depth, base=None):
    """The refined layer, its samples, and the depths of its vertices."""
    base = box() if base is None else base
    normal = np.tile(UP, (len(points), 1))
    layer = base.finer(points + depth[:, None] * normal)
    samples = layer.pressed(points + depth[:, None] * normal, normal, depth)
    return layer, samples, layer.depths(samples)


def height(layer, samples, w):
    """Height of the dented surface at the samples' places (n,) [m]."""
    corners = layer.at(w)[samples.corner]
    return np.einsum("nk,nki->ni", samples.share, corners)[:, 2]


def test_a_box_of_twelve_faces_is_as_deep_as_a_flat_stamp():
    points, depth = flat(0.04)
    layer, _samples, w = pressed_by(points, depth)
    under = (np.abs(layer.surface[:, :2]) < (0.09, 0.29)).all(axis=1)
    under &= layer.surface[:, 2] > TOP - 1e-9
    assert under.sum() > 100
    np.testing.assert_allclose(w[under], 0.04, atol=1e-6)


def test_beside_the_contact_it_fades_as_a_membrane_on_springs():
    """w = d exp(-x / l) beside a long stamp, less a fiftieth; its edge is known to a sample."""
    points, depth = flat(0.04)
    layer, _, w = pressed_by(points, depth)
    x, y, z = layer.surface.T
    edge = points[:, 0].max()
    found, last = [], np.inf
    for off in (0.02, 0.03, 0.04, 0.05):
        ring = (np.abs(x - edge - off) < 0.004) & (np.abs(y) < 0.1) & (z > TOP - 1e-9)
        assert w[ring].mean() < last
        last = w[ring].mean()
        found.append(last)
    slope = np.log(found[0] / found[3]) / 0.03
    assert slope == pytest.approx(1.0 / FADES, rel=0.25)  # the fiftieth makes it steeper
    assert 0.04 * np.exp(-0.02 / FADES) < found[0] < 0.04 * np.exp(-0.007 / FADES)


def test_it_is_exactly_flat_where_nothing_presses():
    points, depth = flat(0.04)
    layer, _, w = pressed_by(points, depth)
    far = np.abs(layer.surface[:, 0]) > 0.1 + 1.3 * REACH
    assert far.any()
    assert (w[far] == 0.0).all()
    below = layer.surface[:, 2] < -TOP + 1e-9
    assert (w[below] == 0.0).all()
    np.testing.assert_array_equal(layer.at(w)[far], layer.surface[far])


@pytest.mark.parametrize("pitch", [0.01, 0.02])
def test_it_follows_a_ball(pitch):
    """Nowhere above a sample, nowhere far below: a fraction of what the samples leave open."""
    radius = 0.11
    points, depth, centre = ball(radius, 0.05, pitch)
    layer, samples, w = pressed_by(points, depth)
    assert (height(layer, samples, w) <= points[:, 2] + 1e-9).all()
    r = np.linalg.norm(layer.surface[:, :2], axis=1)
    under = (r < 0.05) & (layer.surface[:, 2] > TOP - 1e-9)
    exact = TOP - centre[2] + np.sqrt(radius**2 - r[under] ** 2)
    bound = 0.5 * pitch**2 / radius + 0.5 * pitch * 0.05 / radius
    assert np.abs(w[under] - exact).max() < bound


def test_there_is_no_bulge_and_it_never_goes_below_the_frame():
    points, depth, _ = ball(0.3, 0.2, 0.02)
    layer, _, w = pressed_by(points, depth)
    assert w.min() >= 0.0
    assert (w <= layer.thickness).all()
    assert w.max() == pytest.approx(THICK, abs=1e-6)
    inner = np.abs(layer.at(w)) - (SIZE / 2 - THICK)
    assert (inner.max(axis=1) >= -1e-9).all()


def test_a_thin_pillow_dents_on_the_side_that_is_pressed():
    size = np.array([0.5, 0.4, 0.08])
    surface, faces = hp.Box(size).triangles()
    thick = 0.45 * size[2]
    inner, _ = hp.Box(size - 2 * thick).triangles()
    base = LayerSurface(
        surface=surface, inner=inner, faces=faces.astype(int), thickness=np.full(8, thick)
    )
    points, depth = flat(0.02, half=(0.05, 0.05))
    points[:, 2] += size[2] / 2 - TOP
    layer, _, w = pressed_by(points, depth, base)
    top = layer.surface[:, 2] > size[2] / 2 - 1e-9
    assert w[top].max() == pytest.approx(0.02, abs=1e-6)
    assert w[layer.surface[:, 2] < 0.0].max() == 0.0


def test_nothing_presses():
    layer = box()
    none = layer.pressed(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    assert (layer.depths(none) == 0.0).all()
    assert len(layer.finer(np.zeros((0, 3))).surface) == 8
    assert len(layer.near(np.zeros((0, 3)), 1.0)) == 0


def test_everywhere_fine_enough_for_live_views():
    layer = box().finer(None)
    sides = layer.surface[np.roll(layer.faces, -1, axis=1)] - layer.surface[layer.faces]
    assert np.linalg.norm(sides, axis=2).max() <= 0.025
