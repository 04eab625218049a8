"""The watch over all that moves: planes leave out pairs, and change no distance."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.coal_scene import ROUNDING, Watch, _points_of
from support.people import MIDDLE, t_pose

#: Moved along x from pose to pose [m]: from apart into each other.
PATH = np.linspace(0.9, 0.0, 10)
SHAPES = {
    "box": Box((0.3, 0.3, 0.3)),
    "ball": Sphere(0.15),
    "capsule": Capsule(0.1, 0.2),
    "cylinder": Cylinder(0.15, 0.3),
}


def with_things(shape, contact):
    """A watch over one person and an object, and coordinates of both as the object comes in."""
    scene = Scene()
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -1.45))
    turn = rot.exp([0.2, 0.4, -0.3])
    scene.add_object("it", shape, mass=1.0, position=(0.9, MIDDLE, 0.0), quaternion=turn)
    settings = Settings(contact=contact)
    simulator = Simulator(scene, body=Body.default(), settings=settings, fps=30.0)
    start = simulator.world.start([t_pose(np.zeros((2, 3)))[0]])[0]
    (place,) = simulator.world.objects
    poses = np.repeat(start[None], len(PATH), axis=0)
    poses[:, place.qpos] += PATH - 0.9
    return Watch(simulator), poses


def slowly(watch, poses, statics="all"):
    """The same as `Watch.smallest`, pose by pose and pair by pair."""
    found = [watch.gap(pose, statics=statics) for pose in poses]
    return min(d for d, _ in found), sum(d < -ROUNDING for d, _ in found)


@pytest.mark.parametrize("contact", ["skin", "parts"])
@pytest.mark.parametrize("kind", SHAPES)
def test_the_smallest_distance_is_that_of_all_pairs(kind, contact):
    watch, poses = with_things(SHAPES[kind], contact)
    gap, pair, inside = watch.smallest(poses, statics="things")
    assert (gap, inside) == slowly(watch, poses, "things")
    assert 0 < inside < len(poses)
    assert set(pair) == {"person", "it"}
    outside = watch.smallest(poses[: len(poses) - inside], statics="things")
    assert outside[2] == 0
    assert outside[0] > 0.0


def test_what_is_known_is_not_looked_for():
    watch, poses = with_things(SHAPES["ball"], "skin")
    far = watch.smallest(poses[:1], known=1.0, statics="things")
    assert far == (1.0, ("", ""), 0)
    gap, _, inside = watch.smallest(poses)
    assert watch.smallest(poses, known=gap) == (gap, ("", ""), inside)


def test_what_is_told_is_left_out_as_long_as_it_is_told():
    watch, poses = with_things(SHAPES["ball"], "skin")
    parts = {"/".join(name.split("/")[:2]) for name in watch.people[0].names}
    gap, _, inside = watch.smallest(poses, statics="things")
    begun = len(poses) - inside + 1  # the pose of index 0 is the first after the start
    for told in ({(part, "it"): begun for part in parts}, {("it", "person"): begun}):
        assert watch.smallest(poses, statics="things", told=told)[::2] == (gap, inside - 1)
    told = dict.fromkeys(told, len(poses))
    assert watch.smallest(poses, statics="things", told=told)[2] == 0


@pytest.mark.parametrize("kind", SHAPES)
def test_points_and_ball_cover_a_shape(kind):
    shape = SHAPES[kind]
    points, ball = _points_of(shape)
    n = np.random.default_rng(0).normal(size=(500, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    reach = (points @ n.T).max(axis=0) + ball
    if kind == "cylinder":
        true = shape.radius * np.hypot(n[:, 0], n[:, 1]) + 0.5 * shape.length * np.abs(n[:, 2])
        assert (reach >= true - 1e-12).all()
        assert (reach <= true + 0.005 * shape.radius).all()
    else:
        vertices = np.asarray(shape.triangles()[0])
        assert (reach >= (vertices @ n.T).max(axis=0) - 1e-12).all()
