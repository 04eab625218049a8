"""Subdivided meshes: the same surface, no cracks, short edges where asked."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.geometry.mesh_solids import solid_moments
from halfphysics.geometry.subdivision import subdivided

SOFA = hp.Box((2.0, 0.9, 0.4))


def edges(points, faces):
    corners = points[faces]
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)


@pytest.mark.parametrize("length", [0.3, 0.05])
def test_a_box_is_the_same_solid_with_short_edges(length):
    points, faces = subdivided(*SOFA.triangles(), length, 100_000)
    assert edges(points, faces).max() <= length
    assert is_closed(faces.astype(np.int32), len(points))
    volume = solid_moments(points, faces.astype(np.int32))[0]
    assert volume == pytest.approx(SOFA.volume, rel=1e-12)


def test_faces_are_compact():
    """No slivers are made, where a part is cut and where all is: the sofa's own faces have 2.5."""
    for near in (None, lambda centre, radius: centre[:, 0] > 0.5):
        points, faces = subdivided(*SOFA.triangles(), 0.03, 100_000, near)
        sides = edges(points, faces)
        assert (sides.max(axis=1) / sides.min(axis=1)).max() < 6.0


def test_only_what_is_near_is_cut_and_nothing_cracks():
    spot = np.array([0.3, 0.1, 0.2])

    def near(centre, radius):
        return np.linalg.norm(centre - spot, axis=1) < radius + 0.1

    points, faces = subdivided(*SOFA.triangles(), 0.02, 100_000, near)
    everywhere = subdivided(*SOFA.triangles(), 0.02, 100_000)[0]
    assert len(points) < 0.1 * len(everywhere)
    assert is_closed(faces.astype(np.int32), len(points))
    middle = points[faces].mean(axis=1)
    here = np.linalg.norm(middle - spot, axis=1) < 0.1
    assert here.any()
    assert edges(points, faces)[here].max() <= 0.02


def test_further_columns_are_linear_in_the_faces():
    points, faces = SOFA.triangles()
    plane = points @ np.array([0.3, -0.2, 0.7]) + 0.1
    values, _ = subdivided(np.column_stack([points, plane]), faces, 0.1, 100_000)
    np.testing.assert_allclose(
        values[:, 3], values[:, :3] @ np.array([0.3, -0.2, 0.7]) + 0.1, atol=1e-12
    )


def test_the_number_of_vertices_is_bounded_and_the_given_ones_come_first():
    points, faces = SOFA.triangles()
    values, _ = subdivided(points, faces, 0.001, 500)
    assert 100 < len(values) <= 500
    np.testing.assert_array_equal(values[:8], points)
