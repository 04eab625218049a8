"""Planes of a shape among more triangles than it keeps planes for: none within reach is missing."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.geometry.shapes import Mesh
from support.judges.coal_shapes import coal_hull, coal_shape
from support.loose_triangles import around_a_ball

NO_DISC = np.zeros(3)
#: Triangles may stick out of the plane that leaves them out by this [m].
BEHIND = 1.1e-7
#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6


def ball(radius=0.1, points=60):
    """Points of a sphere, by Fibonacci's lattice."""
    z = 1.0 - (2.0 * np.arange(points) + 1.0) / points
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(points)
    flat = np.sqrt(1.0 - z * z)
    return radius * np.stack([flat * np.cos(angle), flat * np.sin(angle), z], axis=1)


def distances(points, corners):
    """Of a hull from triangles (F, 3, 3), each by itself."""
    hull, here = coal_hull(points), coal.Transform3s.Identity()

    def distance(corners):
        triangle = coal_shape(Mesh(corners, np.array([[0, 1, 2]])), solid=False)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        return coal.distance(hull, here, triangle, here, request, result)

    return np.array([distance(t) for t in corners])


@pytest.mark.parametrize("depth", [0.0, 1e-9, 1e-7, 5e-5])
def test_a_triangle_that_touches_by_its_edge_is_as_deep_as_it_has_gone_in(depth):
    """Along its normal it is half the cube deep."""
    half = 0.1
    cube = half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    edge = depth - half
    corners = np.array([[0.0, -1.0, edge], [0.0, 1.0, edge], [0.0, 0.0, -1.0]])
    faces = np.array([[0, 1, 2]])
    planes, nearest, _ = _native.triangle_planes(corners, faces, cube, 0.0, NO_DISC, 0.01)
    assert nearest == pytest.approx(-depth, abs=1e-12)
    assert planes[0][:3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)


@pytest.mark.parametrize(
    ("count", "near", "far", "fine"),
    [
        (40, 0.002, 0.003, 60),
        (100, 0.002, 0.003, 60),
        (700, 0.002, 0.003, 60),
        (2500, 0.002, 0.02, 60),
        (700, 0.008, 0.009, 1500),
        (1500, 0.002, 0.02, 1500),
    ],
)
def test_planes_hold_for_the_reach_that_is_said(count, near, far, fine):
    """Loose triangles near to far from a ball of so many points: none within reach is missing."""
    reach = 0.05
    points = ball(points=fine)
    vertices, faces = around_a_ball(np.random.default_rng(count), count, near=near, far=far)
    planes, nearest, holds = _native.triangle_planes(vertices, faces, points, 0.0, NO_DISC, reach)
    exact = distances(points, vertices[faces])
    assert nearest == pytest.approx(exact.min(), abs=ROUNDING)
    corners = vertices[faces[exact < holds - ROUNDING]]
    heights = corners @ planes[:, :3].T - planes[:, 3]
    assert (heights.max(axis=1) <= BEHIND).any(axis=1).all()
    # Where there are too many for the whole reach, or finding them costs too much: 5 mm.
    if holds < reach:
        assert count >= 700
        assert holds > 0.005


def test_a_small_number_of_planes_holds_for_the_whole_reach():
    vertices, faces = around_a_ball(np.random.default_rng(1), 150, near=0.003)
    planes, _, holds = _native.triangle_planes(vertices, faces, ball(), 0.0, NO_DISC, 0.05)
    assert holds == 0.05
    assert len(planes) > 64  # more than were once kept


@pytest.mark.parametrize("count", [40, 700, 2500])
def test_whether_a_triangle_is_nearer_than_a_range(count):
    """The search that ends at the first one, and the one for the nearest, agree with coal."""
    vertices, faces = around_a_ball(np.random.default_rng(count), count, near=0.002, far=0.02)
    exact = distances(ball(), vertices[faces]).min()
    for share in (0.5, 0.9, 0.999, 1.001, 1.1, 5.0):
        reach = share * exact
        nearer, dist = _native.triangle_nearest(vertices, faces, ball(), 0.0, NO_DISC, reach)
        assert nearer == (share > 1.0)
        assert dist == pytest.approx(min(reach, exact), abs=ROUNDING)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_a_triangle_that_is_met_is_nearer_than_any_range(share):
    """One triangle through the ball among many that are clear of it."""
    vertices, faces = around_a_ball(np.random.default_rng(7), 300, near=0.002, far=0.02)
    z = 0.1 * share
    through = np.array([[-0.3, -0.3, z], [0.3, -0.3, z], [0.0, 0.4, z]])
    n = len(vertices)
    vertices, faces = (
        np.concatenate([vertices, through]),
        np.vstack([faces, [n, n + 1, n + 2]]),
    )
    for reach in (1e-5, 1e-3, 0.1):
        nearer, dist = _native.triangle_nearest(vertices, faces, ball(), 0.0, NO_DISC, reach)
        assert nearer
        assert dist < 0.0


def test_of_a_point_that_is_none_there_is_no_face():
    tree = _native.TriangleTree(np.eye(3), np.array([[0, 1, 2]], np.int32))
    _, face, _ = tree.distance(np.array([[np.nan, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    assert face.tolist() == [-1, 0]
