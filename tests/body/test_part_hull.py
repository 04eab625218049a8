"""Hulls of many, few, flat or no points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations
from halfphysics.body.part_hull import MIN_THICKNESS, part_hull
from halfphysics.geometry.mesh_queries import is_closed


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 40), st.integers(0, 3))
def test_any_points_give_a_closed_solid_that_holds_them(seed: int, n: int, dims: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(scale=0.05, size=(n, 3)) * (np.arange(3) < dims)
    points = points @ rotations.rotvec_to_matrix(rng.normal(size=3)).T + rng.normal(size=3)
    hull = part_hull(points, "part")
    assert is_closed(hull.faces, len(hull.vertices))
    a, b, c = np.moveaxis(hull.vertices[hull.faces], 1, 0)
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1)
    wide = size > 1e-9  # slivers between coplanar corners have no direction of their own
    outward = normals[wide] / size[wide, None]
    depth = np.einsum("fi,fni->fn", outward, points[None] - a[wide][:, None])
    assert depth.max() < 1e-8, "a point outside: 1e-8 m is a sliver's angle times its length"
    assert hull.volume > 0.0
    assert hull.thickened == (n < 4 or dims < 3) or np.ptp(points, axis=0).min() < 0.1


@pytest.mark.parametrize(
    ("points", "volume"),
    [
        ([[0.3, 0.4, 0.5]], MIN_THICKNESS**3),
        ([[0, 0, 0], [0.2, 0, 0]], 0.2 * MIN_THICKNESS**2),
        ([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0.2, 0.1, 0]], 0.02 * MIN_THICKNESS),
        ([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0]], 0.01 * MIN_THICKNESS),
    ],
)
def test_thin_sets_get_a_millimetre(points: list[list[float]], volume: float) -> None:
    hull = part_hull(np.array(points), "part")
    assert hull.thickened
    assert hull.volume == pytest.approx(volume, rel=1e-9)


def test_a_solid_is_left_alone() -> None:
    corners = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.2) for z in (0, 0.3)])
    inner = np.full((5, 3), 0.05)
    hull = part_hull(np.concatenate([corners, inner]), "part")
    assert not hull.thickened
    np.testing.assert_array_equal(hull.vertices, corners)
    assert hull.volume == pytest.approx(0.006, rel=1e-12)


def test_no_points_no_hull() -> None:
    hull = part_hull(np.zeros((0, 3)), "part")
    assert hull.vertices.shape == hull.faces.shape == (0, 3)
    assert hull.volume == 0.0
    assert not hull.thickened
