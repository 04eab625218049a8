"""Solids that are square to axes of their own are found so, and cut as if they were not turned."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from halfphysics.geometry.box_frame import box_frame
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.solid_cutting import pieces_of

ROUNDING = 1e-12


def bracket():
    """An L of two boxes, of one surface."""
    outline = np.array([(0, 0), (0.3, 0), (0.3, 0.05), (0.05, 0.05), (0.05, 0.3), (0, 0.3)])
    n, low = len(outline), np.column_stack([outline, np.zeros(len(outline))])
    ends = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in ends] + [(a + n, b + n, c + n) for a, b, c in ends]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, j + n), (i, j + n, i + n)]
    return np.concatenate([low, low + np.array([0, 0, 0.05])]), np.array(faces)


@pytest.mark.parametrize("seed", range(6))
def test_the_axes_of_what_was_turned_are_found(seed):
    vertices, faces = bracket()
    turn = Rotation.random(random_state=seed).as_matrix()
    frame = box_frame(Mesh(vertices @ turn.T, faces))
    # Each axis is one of the true ones, whatever its sign and order.
    assert np.sort(np.abs(frame.T @ turn), axis=1)[:, :2].max() < ROUNDING
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=ROUNDING)


def test_noise_of_a_scan_moves_the_axes_by_less_than_its_own_angle():
    box = trimesh.creation.box((0.4, 0.3, 0.2))
    for _ in range(4):
        box = box.subdivide()
    turn = Rotation.from_euler("xyz", [0.3, -0.5, 0.7]).as_matrix()
    rough = box.vertices @ turn.T + np.random.default_rng(0).normal(0, 1e-4, box.vertices.shape)
    frame = box_frame(Mesh(rough, box.faces))
    worst = np.sort(np.abs(frame.T @ turn), axis=1)[:, :2].max()
    assert np.degrees(worst) < 0.2


def test_what_has_no_axes_of_its_own_and_what_is_not_turned_stays():
    ball = trimesh.creation.icosphere(3)
    assert box_frame(Mesh(ball.vertices, ball.faces)) is None
    assert box_frame(Mesh(*bracket())) is None


@pytest.mark.parametrize("seed", range(4))
def test_a_turned_solid_is_cut_into_few_pieces(seed):
    """A staircase of 15 pieces before; their union is the bracket wherever it is turned."""
    pytest.importorskip("coacd")
    vertices, faces = bracket()
    turn = Rotation.random(random_state=seed).as_matrix()
    pieces = pieces_of(Mesh(vertices @ turn.T, faces), 0.003, -1)
    assert len(pieces) <= 3
    volume = 0.05 * (0.3 * 0.05 + 0.25 * 0.05)
    assert sum(piece.volume for piece in pieces) == pytest.approx(volume, rel=0.01)
