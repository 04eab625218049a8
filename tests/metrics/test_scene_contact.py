"""Signed distances of a scene and the scores of PSI, POSA and COINS, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import metrics
from halfphysics.metrics.scene_contact import SceneDistance
from support.point_bodies import Track

EXACT = 1e-9


def test_scores_by_hand() -> None:
    """Frames with one of four inside, none, one on the surface."""
    distance = np.array([[-0.1, 0.2, 0.3, 0.4], [1.0, 1.0, 1.0, 1.0], [0.0, 0.5, 0.5, 0.5]])
    scores = metrics.scene_contact(distance)
    assert scores.non_collision_percent == pytest.approx(100 * (0.75 + 1 + 0.75) / 3, abs=EXACT)
    assert scores.non_collision_coins_percent == pytest.approx(100 * 2.75 / 3, abs=EXACT)
    assert scores.contact_percent == pytest.approx(100 / 3, abs=EXACT)


def cube(size: float) -> hp.Mesh:
    from support.boxes import CORNERS, TRIANGLES

    return hp.Mesh(CORNERS * size, TRIANGLES)


def test_distance_is_the_nearest_of_all_items() -> None:
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("ball", hp.Sphere(0.5), position=(0.0, 0.0, 2.0))
    scene.add_static("cube", cube(1.0), position=(3.0, 0.0, 0.5))
    points = np.array([[[0.0, 0, 1.4], [0.1, 0, 2.0], [3.0, 0, 0.4], [3.55, 0, 0.9], [7, 0, -0.2]]])
    found = SceneDistance(scene, 1).of(points, slice(0, 1))
    np.testing.assert_allclose(found, [[0.1, -0.4, -0.4, 0.05, -0.2]], atol=EXACT)
    things = SceneDistance(scene, 1, planes=False).of(points, slice(0, 1))
    assert things[0, 4] > 3.0
    # Far from a mesh it is the distance from its box, which is the mesh here.
    assert things[0, 4] == pytest.approx(np.hypot(3.5, 0.2), abs=EXACT)


def test_signs_of_a_mesh_are_exact_within_its_box() -> None:
    """A corner of the box of a tetrahedron is outside of it."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    scene = hp.Scene()
    scene.add_static("tetrahedron", hp.Mesh(corners, faces))
    points = np.array([[[0.9, 0.9, 0.9], [0.2, 0.2, 0.2], [0.2, 0.2, -0.3]]])
    found = SceneDistance(scene, 1).of(points, slice(0, 1))[0]
    # From the slanted face x + y + z = 1, inside and outside.
    assert found[0] > 0.0
    assert found[1] == pytest.approx(-0.2, abs=EXACT)
    assert found[2] == pytest.approx(0.3, abs=EXACT)


def test_objects_count_where_their_track_is() -> None:
    scene = hp.Scene()
    scene.add_object("ball", hp.Sphere(0.5), mass=1.0)
    assert not SceneDistance(scene, 2).solids
    track = Track(np.array([[0.0, 0, 0], [2.0, 0, 0]]), np.tile([1.0, 0, 0, 0], (2, 1)))
    distance = SceneDistance(scene, 2, {"ball": track})
    found = distance.of(np.zeros((2, 1, 3)), slice(0, 2))
    np.testing.assert_allclose(found[:, 0], [-0.5, 1.5], atol=EXACT)
    np.testing.assert_allclose(distance.of(np.zeros((1, 1, 3)), slice(1, 2)), [[1.5]], atol=EXACT)
