"""Clearances from statics of every kind: by closed forms, and never more than is there."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Sphere
from halfphysics.scene.scene import Scene
from support.judges.convex_obstacles import Obstacles
from support.judges.skin_obstacles import signed_distance

trimesh = pytest.importorskip("trimesh")

SHAPES = {
    "box": Box((0.3, 0.5, 0.2)),
    "sphere": Sphere(0.2),
    "capsule": Capsule(0.1, 0.5),
    "cylinder": Cylinder(0.15, 0.4),
}
PLACE, TURN = np.array([0.4, -0.2, 0.7]), rot.exp([0.3, -0.7, 0.5])


def clearances(scene, points, far, owner=None, settle=True):
    """Of single points (K, 3) that are clouds."""
    obstacles = Obstacles(list(scene.statics.values()))
    cloud, which = obstacles.near(points - far, points + far)
    if owner is not None:
        own = obstacles.owner[which] == owner
        cloud, which = cloud[own], which[own]
    return obstacles.clearance(points[:, None], points, cloud, which, far, settle)


@pytest.fixture(scope="module")
def points():
    return PLACE + np.random.default_rng(0).uniform(-0.7, 0.7, size=(1500, 3))


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("mesh", [False, True])
def test_points_around_a_shape(kind, mesh, points):
    shape, scene, far = SHAPES[kind], Scene(), 0.2
    if mesh:  # of a box the same, of round ones by a mesh that is inside them
        if kind != "box":
            pytest.skip("its triangles are not its surface")
        shape = trimesh.creation.box(extents=SHAPES["box"].size)
    scene.add_static("it", shape, position=PLACE, quaternion=TURN)
    found = clearances(scene, points, far)
    true = signed_distance(SHAPES[kind], (points - PLACE) @ rot.to_matrix(TURN))
    outside = true > 1e-6
    assert 100 < outside.sum() < len(points)
    np.testing.assert_allclose(found[outside], np.minimum(true, far)[outside], atol=2e-6)
    if not mesh:  # within triangles is a place as good as any: coal and the side judge that
        assert (found[~outside] < 2e-6).all()


def test_the_nearest_of_many_counts_and_each_alone(points):
    scene, far = Scene(), 0.3
    for k, shape in enumerate(SHAPES.values()):
        scene.add_static(f"it{k}", shape, position=np.add(PLACE, (0.0, 0.3 * k, 0.0)))
    each = [clearances(scene, points, far, owner=k) for k in range(len(SHAPES))]
    proven = clearances(scene, points, far) == far
    np.testing.assert_array_equal(proven, np.min(each, axis=0) == far)
    assert 100 < proven.sum() < len(points)


def test_a_sheet_between_two_poses_is_not_overlooked():
    """A way through a sheet has no plane; beside it there is one."""
    scene = Scene()
    scene.add_static("it", trimesh.Trimesh([[0, -1, -1], [0, 1, -1], [0, 1, 1], [0, -1, 1]],
                                           [[0, 1, 2], [0, 2, 3]]))  # fmt: skip
    obstacles = Obstacles(list(scene.statics.values()))
    through = np.array([[-0.3, 0.1, 0.1], [0.3, 0.1, 0.2], [0.3, 0.2, 0.1]])
    ways = np.stack([through, np.add(through, (0.4, 0.0, 0.0)), np.add(through, (0.0, 2.0, 0.0))])
    cloud, which = obstacles.near(ways.min(axis=1), ways.max(axis=1))
    found = obstacles.clearance(ways, ways.mean(axis=1), cloud, which, 1e-9)
    np.testing.assert_array_equal(found >= 1e-9, [False, True, True])
