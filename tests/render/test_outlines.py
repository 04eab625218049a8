"""Lines of a picture: on the edges of things, as wide as asked, on the ground in squares."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box
from halfphysics.render.look import DARK, GRID, LIGHT
from halfphysics.render.outlines import drawn, edges, shade, squares
from halfphysics.render.rasterizer import Camera, Surface, render

HEIGHT = 300


@pytest.fixture(scope="module")
def box():
    vertices, faces = Box((1.0, 2.0, 3.0)).triangles()
    return Surface(vertices=vertices, faces=faces, color=(0.9, 0.9, 0.9))


def test_a_box_has_twelve_edges_just_outside_of_it(box):
    found = edges(box)
    assert found.shape == (12, 2, 3)
    lengths = np.sort(np.linalg.norm(found[:, 1] - found[:, 0], axis=1))
    np.testing.assert_allclose(lengths, [1.0] * 4 + [2.0] * 4 + [3.0] * 4, atol=1e-9)
    outside = np.abs(found) - [0.5, 1.0, 1.5]
    assert outside.max() == pytest.approx(0.001)


def test_a_surface_of_noise_has_no_edges():
    rng = np.random.default_rng(0)
    vertices = rng.normal(size=(3000, 3))
    faces = rng.integers(0, 3000, size=(4000, 3))
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])]
    assert edges(Surface(vertices=vertices, faces=faces)).shape == (0, 2, 3)


def test_strips_are_as_wide_as_asked_near_and_far():
    camera = Camera(position=np.array([0.0, -5.0, 1.0]), target=np.array([0.0, 0.0, 1.0]))
    lines = np.array([[[-1.0, 1.0, 0.0], [1.5, 4.0, 2.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]])
    strips = drawn(lines, (0.0, 0.0, 0.0), camera, HEIGHT, width=2.0)
    local = (strips.vertices - camera.position) @ camera.axes().T
    focal = 0.5 * HEIGHT / np.tan(np.radians(camera.fov) / 2)
    pixels = (focal * local[:, :2] / local[:, 2:]).reshape(-1, 4, 2)
    # Corners: start and end of one side, then end and start of the other.
    for one, other in ((0, 3), (1, 2)):
        width = np.linalg.norm(pixels[:, one] - pixels[:, other], axis=1)
        np.testing.assert_allclose(width, 2.0, rtol=1e-9)


def test_lines_behind_the_camera_are_cut_off():
    camera = Camera(position=np.array([0.0, -5.0, 1.0]), target=np.array([0.0, 0.0, 1.0]))
    behind = np.array([[[0.0, -9.0, 1.0], [0.0, -7.0, 1.0]]])
    assert drawn(behind, (0.0, 0.0, 0.0), camera, HEIGHT) is None
    through = np.array([[[0.3, -9.0, 1.0], [0.3, 7.0, 1.0]]])
    strip = drawn(through, (0.0, 0.0, 0.0), camera, HEIGHT)
    assert np.isfinite(strip.vertices).all()
    assert ((strip.vertices - camera.position) @ camera.axes()[2]).min() > camera.near


def test_white_on_white_shows_its_outline(box):
    camera = Camera.framing(box.vertices, (1.0, -2.0, 0.7), size=(HEIGHT, HEIGHT))
    strips = drawn(edges(box), shade(box.color, LIGHT), camera, HEIGHT)
    plain, lined = (render(s, camera, (HEIGHT, HEIGHT)) for s in ([box], [box, strips]))
    darker = plain.astype(int).mean(axis=2) - lined.astype(int).mean(axis=2)
    assert (darker > 30).sum() > 900  # nine edges of about 150 pixels
    assert (darker > 30).mean() < 0.05
    assert shade((0.5, 0.5, 0.5), DARK)[0] > 0.5 > shade((0.5, 0.5, 0.5), LIGHT)[0]


def test_squares_lie_on_whole_multiples_within_their_circle():
    lines = squares(np.array([0.3, -1.2, 5.0]), 4.0, 0.25)
    assert (lines[..., 2] == 0.25).all()
    assert np.linalg.norm(lines[..., :2] - [0.3, -1.2], axis=2) == pytest.approx(4.0)
    level = lines[:, 0] == lines[:, 1]
    assert (level[:, :2].sum(axis=1) == 1).all()
    steps = lines[:, 0][level & [True, True, False]] / GRID
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-12)
    assert len(lines) == 32  # 16 each way
