"""Distances of all shapes at any pose: correct, and without effect on the simulation."""

from __future__ import annotations

import coal
import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.coal_shapes import coal_hull
from support.people import along_x, violent

SAME = 1e-9  # two computations of one distance, in doubles [m]
COAL = 3e-6  # coal stops at 1e-6 of the squared distance; measured 1.1e-6 [m]
PARTS = Settings(contact="parts")


@pytest.fixture(scope="module")
def body():
    return Body.default()


def measured(simulator, motion, reach):
    """Distances (T, shapes) and nearest statics at a motion's poses."""
    world = simulator.world
    qpos = np.array([world.start([motion[t]])[0] for t in range(len(motion))])
    static = np.full((len(qpos), len(world.shape_name)), 7, dtype=np.int32)
    return world.stepper.clearances(qpos, reach, static), static, qpos


def part_points(simulator, qpos):
    """World vertices of every part at one pose, in the order of the shapes."""
    person = simulator.world.people[0]
    frames, quats = simulator.world.stepper.body_frames(qpos)
    for part in person.body.variant.parts:
        if len(part.vertices):
            b = simulator.world.model.body(f"{person.name}/{part.name}").id
            yield rot.rotate(quats[b], part.vertices) + frames[b]


def test_from_a_half_space_by_hand(body):
    """Both signs: a part's distance from a floor is the height of its lowest vertex."""
    scene = Scene()
    normal = np.array([0.6, 0.0, 0.8])
    scene.add_static("slope", Plane(normal=normal, offset=0.1))
    simulator = Simulator(scene, body=body, settings=PARTS)
    motion = violent(frames=6)
    dist, static, qpos = measured(simulator, motion, 100.0)
    expected = [[points @ normal - 0.1 for points in part_points(simulator, q)] for q in qpos]
    lowest = np.array([[heights.min() for heights in row] for row in expected])
    assert lowest.min() < -0.1
    assert lowest.max() > 0.1
    np.testing.assert_allclose(dist, lowest, atol=SAME)
    assert (static == 0).all()


def test_hulls_of_the_skin_by_its_vertices(body):
    """Every vertex is in a skin hull, and no hull extends beyond its vertices."""
    scene = Scene()
    scene.add_static("floor", Plane(offset=-0.4))
    simulator = Simulator(scene, body=body, settings=Settings(contact="skin"))
    motion = violent(frames=4)
    dist, _, _ = measured(simulator, motion, 100.0)
    parts = simulator.world.shape_part
    assert len(parts) > len(set(parts))  # some parts have several hulls
    lowest = body.vertices(motion)[..., 2].min(axis=1) + 0.4
    assert lowest.min() < 0.0
    np.testing.assert_allclose(dist.min(axis=1), lowest, atol=SAME)


def test_from_boxes_and_triangles_by_coal(body):
    """A box as a solid and as twelve triangles, each nearest at its own place."""
    scene = Scene()
    box = Box((0.1, 1.0, 2.0))
    turn = rot.exp([0.2, 0.1, 0.4])
    scene.add_static("solid", box, position=(0.6, 0.1, 0.2), quaternion=turn)
    scene.add_static("mesh", Mesh(*box.triangles()), position=(-0.7, 0.0, 0.1), quaternion=turn)
    simulator = Simulator(scene, body=body, settings=PARTS)
    motion = along_x(3.0, 5, start=0.2)
    dist, static, qpos = measured(simulator, motion, 100.0)
    places = [coal.Transform3s(rot.to_matrix(turn), s.position) for s in scene.statics.values()]
    solid = coal.Box(*box.size)
    met = 0
    for t, q in enumerate(qpos):
        for k, points in enumerate(part_points(simulator, q)):
            gaps = [
                coal.distance(
                    coal_hull(points),
                    coal.Transform3s(),
                    solid,
                    place,
                    coal.DistanceRequest(),
                    coal.DistanceResult(),
                )
                for place in places
            ]
            if min(gaps) > 0.0:
                assert dist[t, k] == pytest.approx(min(gaps), abs=COAL)
                assert static[t, k] == int(np.argmin(gaps))
            else:
                met += 1
                assert dist[t, k] <= COAL
    assert 3 < met < dist.size - 100


def test_beyond_the_range_ignored_and_objects(body):
    scene = Scene()
    scene.add_static("floor", Plane(offset=-1.0))
    scene.add_static("ghost", Plane(offset=0.5))
    scene.ignore("ghost", "person")
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0.0, 0.0, -0.9))
    simulator = Simulator(scene, body=body, settings=PARTS)
    motion = along_x(0.0, 2, start=0.0)
    dist, static, qpos = measured(simulator, motion, 0.5)
    far, _, _ = measured(simulator, motion, 100.0)
    people = simulator.world.shape_part >= 0
    assert np.isnan(dist[:, ~people]).all()
    assert (static[:, ~people] == -1).all()
    near = far[:, people] < 0.5
    assert 5 < near.sum() < near.size - 5
    np.testing.assert_array_equal(dist[:, people], np.where(near, far[:, people], np.inf))
    np.testing.assert_array_equal(static[:, people], np.where(near, 0, -1))
    with pytest.raises(ValueError, match="bad shape of qpos"):
        simulator.world.stepper.clearances(qpos[:, :-1].copy(), 0.5)
    with pytest.raises(ValueError, match="bad shape of nearest"):
        simulator.world.stepper.clearances(qpos, 0.5, np.zeros((1, 1), dtype=np.int32))


def test_the_simulation_does_not_notice(body):
    """The minimum equals the stepper's value at its own pose; the run continues bit for bit."""
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.5, 0.0, 0.0))
    motion = along_x(1.5, 30, start=-0.2)
    runs = []
    for asked in (False, True):
        simulator = Simulator(scene, body=body)
        stepper = simulator.world.stepper
        simulator.reset(motion[0])
        touched = False
        for t in range(1, len(motion)):
            frame = simulator.step(motion[t])
            touched |= len(frame.contacts.part) > 0
            if asked:
                before = stepper.save().tobytes()
                here, _, _ = measured(simulator, motion[t : t + 2] if t < 28 else motion[:2], 1.0)
                own = stepper.clearances(stepper.qpos()[None], simulator.settings.clearance_range)
                assert stepper.save().tobytes() == before
                assert own.min() == pytest.approx(frame.clearance, abs=SAME)
                assert np.isfinite(here).any()
        assert touched
        runs.append(stepper.save().tobytes())
    assert runs[0] == runs[1]
