"""Mesh integrals against closed forms; hulls against their definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.geometry.mesh_solids import convex_hull, solid_moments
from halfphysics.geometry.shapes import Box


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**31))
def test_a_turned_and_moved_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    box = Box(rng.uniform(0.1, 2.0, 3))
    vertices, faces = box.triangles()
    turn, shift = rotations.rotvec_to_matrix(rng.normal(size=3)), rng.normal(scale=5.0, size=3)
    volume, centre, inertia = solid_moments(vertices @ turn.T + shift, faces)
    assert volume == pytest.approx(box.volume, rel=1e-11)
    np.testing.assert_allclose(centre, shift, atol=1e-11)
    expected = box.volume * turn @ box.unit_inertia() @ turn.T
    np.testing.assert_allclose(inertia, expected, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(inertia, inertia.T)


def test_inside_out_is_negative_and_flat_is_zero() -> None:
    vertices, faces = Box((1.0, 2.0, 3.0)).triangles()
    volume, centre, inertia = solid_moments(vertices, faces[:, ::-1])
    assert volume == pytest.approx(-6.0)
    np.testing.assert_allclose(centre, 0.0, atol=1e-15)
    assert (np.linalg.eigvalsh(inertia) < 0.0).all()
    sheet = np.array([[0, 1, 2], [0, 2, 1]])
    assert solid_moments(np.eye(3), sheet)[0] == 0.0


def test_hull_of_points() -> None:
    points = np.random.default_rng(0).normal(size=(500, 3))
    vertices, faces = convex_hull(points, "test")
    assert is_closed(faces, len(vertices))
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    assert ((points[:, None] - a) * normal).sum(axis=-1).max() < 1e-12
    assert solid_moments(vertices, faces)[0] > 0.0
    # Corners are kept unchanged, each once.
    assert len({tuple(v) for v in vertices} & {tuple(p) for p in points}) == len(vertices)


@pytest.mark.parametrize("points", [np.eye(3), np.diag([1.0, 1.0, 0.0]), np.zeros((9, 3))])
def test_flat_points_have_no_hull(points: np.ndarray) -> None:
    with pytest.raises(InputError, match=r"cup: .*no volume"):
        convex_hull(points, "cup")
