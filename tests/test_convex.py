"""Distances of convex shapes and separating planes of triangles, against an independent library."""

from __future__ import annotations

import coal
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from halfphysics import _native
from halfphysics import rotations as rot
from halfphysics.colliders import convex_collider, hull_collider
from halfphysics.shapes import Box, Capsule, Cylinder, Sphere

MICROMETRE = 1e-6


def coal_hull(points):
    hull = ConvexHull(points)
    vertices = points[hull.vertices]
    index = {int(v): i for i, v in enumerate(hull.vertices)}
    centre = vertices.mean(axis=0)
    triangles = coal.StdVec_Triangle()
    for simplex in hull.simplices:
        a, b, c = (index[int(v)] for v in simplex)
        outward = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        if outward @ (vertices[a] - centre) < 0:
            b, c = c, b
        triangles.append(coal.Triangle(a, b, c))
    corners = coal.StdVec_Vec3s()
    for v in vertices:
        corners.append(v)
    return coal.Convex(corners, triangles)


def random_turn(rng):
    return rot.to_matrix(rot.normalize(rng.normal(size=4)))


def distance(a, b):
    return _native.convex_distance(a.vertices, a.normals, a.radius, b.vertices, b.normals, b.radius)


def test_distance_of_hulls_agrees_with_coal():
    rng = np.random.default_rng(1)
    request = coal.DistanceRequest()
    checked = 0
    for _ in range(300):
        a = rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.01, 0.3)
        b = rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.01, 0.3)
        shift = rng.normal(size=3)
        shift *= rng.uniform(0.0, 2.0) / np.linalg.norm(shift)
        expected = coal.distance(
            coal_hull(a),
            coal.Transform3s.Identity(),
            coal_hull(b),
            coal.Transform3s(np.eye(3), shift),
            request,
            coal.DistanceResult(),
        )
        dist, normal, pa, pb = distance(hull_collider(a), hull_collider(b + shift))
        if expected > 1e-6:
            checked += 1
            assert dist == pytest.approx(expected, abs=MICROMETRE)
            # The witness: nearest points at that distance, and a plane that truly separates.
            np.testing.assert_allclose(pa - pb, dist * normal, atol=1e-9)
            gap = (a @ normal).min() - ((b + shift) @ normal).max()
            assert gap == pytest.approx(expected, abs=MICROMETRE)
        elif expected < -1e-6:
            assert dist < 0.0
            # An upper bound of the depth, and moving by it along the normal does separate.
            gap = (a @ normal).min() - ((b + shift) @ normal).max()
            assert gap == pytest.approx(dist, abs=1e-9)
            assert -dist >= -expected - MICROMETRE
    assert checked > 150


@pytest.mark.parametrize(
    ("shape", "peer"),
    [
        (Box((0.2, 0.3, 0.4)), coal.Box(0.2, 0.3, 0.4)),
        (Sphere(0.2), coal.Sphere(0.2)),
        (Capsule(0.1, 0.4), coal.Capsule(0.1, 0.4)),
        (Cylinder(0.1, 0.4), coal.Cylinder(0.1, 0.4)),
    ],
)
def test_primitives_agree_with_coal(shape, peer):
    rng = np.random.default_rng(2)
    # A cylinder is the prism around it: up to r (1/cos(pi/64) - 1) = 0.12 mm nearer.
    slack = 1.3e-4 if isinstance(shape, Cylinder) else MICROMETRE
    box = Box((0.5, 0.1, 0.2))
    for _ in range(100):
        turn = random_turn(rng)
        shift = rng.normal(size=3)
        shift *= rng.uniform(0.5, 1.5) / np.linalg.norm(shift)
        expected = coal.distance(
            peer,
            coal.Transform3s(turn, shift),
            coal.Box(*box.size),
            coal.Transform3s.Identity(),
            coal.DistanceRequest(),
            coal.DistanceResult(),
        )
        dist, *_ = distance(convex_collider(shape).moved(turn, shift), convex_collider(box))
        assert expected - slack <= dist <= expected + MICROMETRE


def soup(rng, triangles):
    corners = rng.uniform(-1.0, 1.0, size=(triangles, 1, 3))
    corners = corners + rng.normal(size=(triangles, 3, 3)) * 0.15
    corners[0] = corners[0, 0]  # a triangle of no extent
    corners[1, 2] = corners[1, 1]  # and one of no area
    vertices = corners.reshape(-1, 3)
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


def test_planes_separate_from_every_triangle_in_reach():
    """Planes are the whole truth: beyond all of them nothing within reach is met."""
    rng = np.random.default_rng(3)
    vertices, faces = soup(rng, 300)
    corners = vertices[faces]
    seen = 0
    for _ in range(100):
        points = rng.normal(size=(20, 3)) * 0.08 + rng.uniform(-1.2, 1.2, size=3)
        hull = hull_collider(points)
        reach = 0.3
        planes, nearest = _native.triangle_planes(vertices, faces, hull.vertices, 0.0, reach)
        exact = np.array(
            [
                distance(hull, hull_collider(t))[0] if np.ptp(t, axis=0).max() > 0 else np.inf
                for t in corners
            ]
        )
        if exact.min() <= 1e-6:
            assert nearest <= 1e-6
            continue
        seen += len(planes) > 0
        assert nearest == pytest.approx(min(exact.min(), reach), abs=MICROMETRE)
        for normal, offset, dist in ((p[:3], p[3], p[4]) for p in planes):
            assert (hull.vertices @ normal).min() - offset == pytest.approx(dist, abs=1e-9)
        for triangle, dist in zip(corners, exact, strict=True):
            if dist < reach - 1e-6:
                heights = triangle @ planes[:, :3].T - planes[:, 3]
                assert (heights.max(axis=0) <= 1.1e-7).any()  # wholly behind one plane
    assert seen > 30


def test_a_finely_divided_floor_gives_one_plane():
    n = 40
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij")
    corner = (i * n + j).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + n, corner + 1], 1),
            np.stack([corner + n, corner + n + 1, corner + 1], 1),
        ]
    ).astype(np.int32)
    foot = hull_collider(Box((0.1, 0.25, 0.06)).convex_vertices() + np.array([0.013, 0.027, 0.035]))
    planes, nearest = _native.triangle_planes(vertices, faces, foot.vertices, 0.0, 0.05)
    assert len(planes) == 1
    np.testing.assert_allclose(planes[0, :3], [0, 0, 1], atol=1e-12)
    assert nearest == pytest.approx(0.005, abs=1e-12)
