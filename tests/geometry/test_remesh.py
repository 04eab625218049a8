"""A surface made anew: closed, of the same solid, also where the mesh crosses itself."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.remesh import cell_for, remeshed

trimesh = pytest.importorskip("trimesh")

CELL = 0.02


def mesh(made):
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces))


def test_a_ball_stays_a_ball():
    """Chords of a sphere of radius r are h^2 / (8 r) deep, across a cell's diagonal three times."""
    again = remeshed(mesh(trimesh.creation.icosphere(4, 0.5)), CELL)
    away = np.abs(np.linalg.norm(again.vertices, axis=1) - 0.5)
    assert again.closed
    assert away.max() < 3 * CELL**2 / (8 * 0.5) + 1e-3  # 1 mm: the ball itself is of triangles
    assert again.volume == pytest.approx(4 / 3 * np.pi * 0.5**3, rel=0.01)


def test_outward_and_where_it_was():
    again = remeshed(
        mesh(trimesh.creation.box((1.0, 0.6, 0.4)).apply_translation((5, -3, 2))), CELL
    )
    a, b, c = np.moveaxis(again.vertices[again.faces], 1, 0)
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(0.24, rel=0.01)
    low, high = again.vertices.min(axis=0), again.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [(4.5, -3.3, 1.8), (5.5, -2.7, 2.2)], atol=CELL / 2)


def test_solids_that_cross_become_one():
    parts = [trimesh.creation.box((1, 0.2, 0.2)), trimesh.creation.box((0.2, 1, 0.2))]
    again = remeshed(mesh(trimesh.util.concatenate(parts)), CELL)
    assert again.closed
    assert trimesh.Trimesh(again.vertices, again.faces).body_count == 1
    assert again.volume == pytest.approx(0.04 + 0.04 - 0.008, rel=0.02)


def test_what_encloses_nothing_is_said():
    sheet = Mesh(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0.0)]), np.array([(0, 1, 2)]))
    with pytest.raises(InputError, match="encloses nothing"):
        remeshed(sheet, CELL)
    with pytest.raises(InputError, match="too large"):
        remeshed(mesh(trimesh.creation.box((1, 1, 1))), 1e-4)


def test_cells_by_the_number_of_quads():
    ball = mesh(trimesh.creation.icosphere(4, 0.5))
    for quads in (2_000, 8_000):
        made = len(remeshed(ball, cell_for(ball, quads, 0.0)).faces) // 2
        assert made == pytest.approx(quads, rel=0.15)
    assert cell_for(ball, 10**9, 0.05) == 0.05
