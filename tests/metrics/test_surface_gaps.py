"""Signed distances from shapes by other methods, and gaps above what can carry skin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.metrics.surface_gaps import carrying_gaps, signed_distance
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from support.point_bodies import Ball, Drift, Track

SHAPES = (
    Plane((0.6, 0.0, 0.8), 0.1),
    Box((0.4, 0.6, 1.0)),
    Sphere(0.3),
    Capsule(0.2, 0.5),
    Cylinder(0.3, 0.8),
    Mesh(*Box((0.4, 0.6, 1.0)).triangles()),
)
NO_FACES = np.zeros((0, 3), dtype=np.int32)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_inside_it_is_the_depth_and_the_way_leads_to_the_surface(shape):
    points = np.random.default_rng(1).uniform(-0.8, 0.8, (400, 3))
    distance, way = signed_distance(shape, points)
    assert np.maximum(-distance, 0.0) == pytest.approx(shape.depth(points), abs=1e-12)
    assert np.linalg.norm(way, axis=1) == pytest.approx(np.ones(len(points)))
    there = signed_distance(shape, points - distance[:, None] * way)[0]
    assert np.abs(there).max() < 1e-9


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_it_changes_by_no_more_than_the_way(shape):
    rng = np.random.default_rng(2)
    a = rng.uniform(-0.8, 0.8, (400, 3))
    b = a + rng.normal(scale=0.05, size=a.shape)
    change = np.abs(signed_distance(shape, a)[0] - signed_distance(shape, b)[0])
    assert (change <= np.linalg.norm(a - b, axis=1) + 1e-9).all()


def _gap(points, scene, objects=None):
    cloud = Ball(np.asarray(points, dtype=float), NO_FACES)
    still = Drift(np.zeros((2, 3)))
    return carrying_gaps(still, cloud, scene, np.arange(len(points)), objects=objects)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.4), st.floats(-3.0, 3.0))
def test_a_point_above_a_turned_box(height, yaw):
    scene = Scene()
    turn = rot.exp([0.0, 0.0, yaw])
    scene.add_static("table", Box((1.0, 0.6, 0.1)), position=(2.0, 1.0, 0.7), quaternion=turn)
    found = _gap([[2.0, 1.0, 0.75 + height]], scene)
    assert found.gap == pytest.approx(np.full((2, 1), height), abs=1e-12)
    assert found.names[found.item[0, 0]] == "table"


def test_walls_and_ceilings_carry_nobody():
    scene = Scene()
    scene.add_static("wall", Box((0.1, 2.0, 2.0)), position=(0.06, 0.0, 0.0))
    scene.add_static("ceiling", Box((4.0, 4.0, 0.1)), position=(0.0, 0.0, 0.5))
    found = _gap([[0.0, 0.0, 0.0]], scene)
    assert np.isinf(found.gap).all()
    assert (found.vertex == -1).all()
    assert (found.item == -1).all()
    scene.add_static("floor", Plane(offset=-0.2))
    found = _gap([[0.0, 0.0, 0.0], [0.0, 0.0, -0.3]], scene)
    assert found.gap[0] == pytest.approx([0.2, -0.1])
    assert found.whole == pytest.approx([-0.1, -0.1])


def test_an_object_carries_where_it_is():
    scene = Scene()
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, 0.0))
    track = Track(np.array([[0.0, 0, 0], [0.0, 0, -0.5]]), np.tile([1.0, 0, 0, 0], (2, 1)))
    found = _gap([[0.0, 0.0, 0.3]], scene, {"ball": track})
    assert found.gap[:, 0] == pytest.approx([0.2, 0.7])


def test_skin_that_faces_up_may_be_left_out():
    """Every vertex of a body in many poses, with and without those that face up."""
    body, rng = Body.default(), np.random.default_rng(5)
    rotations = rng.normal(scale=0.5, size=(6, 55, 3))
    rotations[:, 0] = rng.normal(size=(6, 3))
    motion = Motion(np.tile([0.0, 0.0, 0.3], (6, 1)), rotations, 30.0)
    scene = Scene()
    scene.add_static("floor", Plane(offset=-1.0))
    scene.add_static("seat", Box((0.4, 0.4, 0.3)), position=(0.2, 0.0, -0.3))
    group = body.weights.argmax(axis=1)
    every = Ball(np.zeros((1, 3)), NO_FACES)
    every.vertices = body.vertices
    found = [carrying_gaps(motion, b, scene, group) for b in (body, every)]
    # The smallest of all is the same; that of a part may be at its edge, in the middle of skin.
    assert found[0].whole == pytest.approx(found[1].whole, abs=1e-9)


def test_what_is_beyond_reach_is_infinite():
    scene = Scene()
    scene.add_static("floor", Plane())
    cloud, still = Ball(np.array([[0.0, 0, 0.2], [0.0, 0, 0.4]]), NO_FACES), Drift(np.zeros((2, 3)))
    found = carrying_gaps(still, cloud, scene, np.arange(2), reach=0.3)
    assert found.gap[0] == pytest.approx([0.2, np.inf])


def test_a_mesh_gives_what_its_shape_gives():
    """Pruning by boxes and by the smallest gap so far leaves the result as it is."""
    rng = np.random.default_rng(3)
    points = rng.uniform(-1.0, 1.0, (300, 3)) + np.array([0.0, 0.0, 0.4])
    box, gaps = Box((0.7, 0.9, 0.5)), []
    for shape in (box, Mesh(*box.triangles())):
        scene = Scene()
        scene.add_static("low", shape, position=(0.3, 0.0, -0.4), quaternion=rot.exp([0, 0.2, 0.5]))
        scene.add_static("high", shape, position=(-0.4, 0.1, 0.0))
        cloud = Ball(points, NO_FACES)
        gaps.append(carrying_gaps(Drift(np.zeros((2, 3))), cloud, scene, np.arange(300) % 7).gap)
    assert gaps[1] == pytest.approx(gaps[0], abs=1e-9)


def test_every_frame_is_posed_once(monkeypatch):
    """Not all frames for each batch of them, which is quadratic in the length of a clip."""
    body, posed, real = Body.default(), [], Body.joint_frames

    def counted(self, motion):
        posed.append(len(motion))
        return real(self, motion)

    monkeypatch.setattr(Body, "joint_frames", counted)
    motion = Motion(np.tile([0.0, 0.0, 1.0], (70, 1)), np.zeros((70, 55, 3)), 30.0)
    scene = Scene()
    scene.add_static("floor", Plane())
    carrying_gaps(motion, body, scene, np.zeros(len(body.rest_vertices), dtype=int))
    assert sum(posed) == 70
    assert len(posed) > 1
