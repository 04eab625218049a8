"""Planes between convex sets prove the distances that closed forms and coal know, and no more."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from support.judges.coal_shapes import coal_hull
from support.judges.separation import nearest_to_origin, planes
from support.judges.triangle_soup import to_triangles

#: What the search may leave of a distance of some decimetres [m].
LEFT = 1e-6


def clouds(count, points, size, rng):
    """Random point sets of a few decimetres."""
    return 0.3 * rng.normal(size=(count, 1, 3)) + size * rng.normal(size=(count, points, 3))


def search(a, b, far, settle):
    def highest(pair, n):
        return b[pair, np.einsum("kmi,ki->km", b[pair], n).argmax(axis=1)]

    return planes(a, highest, a[:, 0] - b[:, 0], far, settle)


def test_distances_are_those_of_coal():
    rng = np.random.default_rng(0)
    a, b = clouds(300, 40, 0.08, rng), clouds(300, 12, 0.1, rng)
    normal, found = search(a, b, np.inf, settle=True)
    here = coal.Transform3s()
    known = np.array([
        coal.distance(coal_hull(p), here, coal_hull(q), here, coal.DistanceRequest(),
                      coal.DistanceResult())
        for p, q in zip(a, b, strict=True)
    ])  # fmt: skip
    apart = known > 0.0
    assert 50 < apart.sum() < 300
    assert np.abs(found - known)[apart].max() < LEFT
    assert (found[~apart] <= 0.0).all()  # nothing separates what overlaps
    gaps = np.einsum("kmi,ki->km", a, normal).min(axis=1)
    gaps -= np.einsum("kmi,ki->km", b, normal).max(axis=1)
    np.testing.assert_allclose(gaps, found, atol=1e-12)  # what is said is what the plane proves


@pytest.mark.parametrize("far", [1e-9, 0.005, 0.05])
def test_what_is_asked_is_proven_exactly_where_it_is_true(far):
    rng = np.random.default_rng(1)
    a, b = clouds(1000, 30, 0.08, rng), clouds(1000, 3, 0.1, rng)
    true = search(a, b, np.inf, settle=True)[1]
    clear = np.abs(true - far) > LEFT
    found = search(a, b, far, settle=False)[1]
    np.testing.assert_array_equal((found >= far)[clear], (true >= far)[clear])


def test_nearest_points_of_triangles_are_as_far_as_their_distances():
    rng = np.random.default_rng(2)
    triangles = rng.normal(size=(2000, 3, 3)) + rng.normal(size=(2000, 1, 3))
    triangles[::7, 2] = triangles[::7, 1]  # some are edges, some are points
    triangles[::14, 1] = triangles[::14, 2] = triangles[::14, 0]
    near = nearest_to_origin(triangles)
    far = to_triangles(np.zeros((2000, 3)), triangles)
    np.testing.assert_allclose(np.linalg.norm(near, axis=1), far, atol=1e-9)
    assert to_triangles(near, triangles).max() < 1e-9


def test_without_a_direction_nothing_is_proven():
    """Two clouds in one place, searched from no direction: no plane separates them."""
    cloud = np.random.default_rng(3).uniform(-1.0, 1.0, size=(1, 20, 3))

    def highest(pair, n):
        return cloud[pair, np.einsum("kmi,ki->km", cloud[pair], n).argmax(axis=1)]

    _, proven = planes(cloud, highest, np.zeros((1, 3)), 0.0)
    assert proven[0] < 0.0
