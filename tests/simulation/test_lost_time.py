"""A person between a moving and a fixed wall: the wall moves on as the body yields, then waits."""

from __future__ import annotations

import time

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import t_pose

FRAMES = 60
#: Minimum frames per second of CPU, on a busy machine (alone 40 to 200; 0.4 without a bound on
#: the work of a substep).
RATE = 10.0
#: Position of the walls [m]: along the axis, the fixed wall, start of the moving one.
WAYS = {"from behind": (0, 0.4, -1.0), "from the side": (1, 0.7, -1.5)}
SETTINGS = {
    "skin": as_it_is(),
    "parts": as_it_is(contact="parts"),
    "limp": Settings.paper(),
    "firm": as_it_is(stiffness=10.0),
}


@pytest.fixture(scope="module")
def body():
    return Body.default()


def press(way, speed=1.2, stop=True):
    """A wall that moves at `speed` [m/s]."""
    axis, stands, start = WAYS[way]
    size = np.full(3, 3.0)
    size[axis] = 0.1
    position, path = np.zeros(3), np.zeros((FRAMES, 3))
    position[axis] = stands
    path[:, axis] = start + speed * np.arange(FRAMES) / 30.0
    scene = Scene()
    if stop:
        scene.add_static("stop", Box(tuple(size)), position=position)
    scene.add_moving("wall", Box(tuple(size)), path, fps=30.0)
    return scene


def crush(body, way, settings=None, **options):
    scene = press(way, **options)
    simulator = Simulator(scene, body=body, settings=settings, fps=30.0)
    motion = t_pose(np.zeros((FRAMES, 3)))
    simulator.reset(motion[0])
    return [simulator.step(motion[t]) for t in range(1, FRAMES)]


@pytest.mark.parametrize("settings", SETTINGS)
@pytest.mark.parametrize("way", WAYS)
def test_who_is_crushed_stays_whole_and_costs_no_fortune(body, way, settings):
    begin = time.process_time()
    frames = crush(body, way, SETTINGS[settings])
    took = time.process_time() - begin
    assert took < FRAMES / RATE, f"{took:.1f} s"
    axis, stands, start = WAYS[way]
    wall = np.array([f.objects["wall"][0][axis] for f in frames])
    lost = np.array([f.lost_time for f in frames])
    # The wall moves on until no room is left; then it stops, late by the lost time.
    assert (np.diff(wall) >= -1e-9).all()
    assert wall[-1] < stands - 0.2
    assert wall[-1] == pytest.approx(start + 1.2 * (FRAMES - 1) / 30.0 - 1.2 * lost.sum(), abs=1e-6)
    assert lost.sum() > 0.25
    assert (lost <= 1.0 / 30.0 + 1e-9).all()  # no more than the frame has
    # No body enters a wall at any moment, and no velocity explodes.
    turns = np.array([f.pose.rotations for f in frames])
    assert np.isfinite(turns).all()
    if settings == "skin":
        path = np.array([f.pose.translation for f in frames])
        skin = body.vertices(Motion(path, turns, 30.0))[..., axis]
        assert (skin.max(axis=1) < stands - 0.05).all()
        assert (skin.min(axis=1) > wall + 0.05).all()
    assert min(f.clearance for f in frames) > 0.0


def test_who_gets_out_lets_the_wall_go_on(body):
    """A crushed person is pulled upwards, out: wall and person then follow their motions."""
    path = np.zeros((FRAMES, 3))
    path[:, 2] = 4.0 * np.clip(np.arange(FRAMES) / 30.0 - 1.0, 0.0, None)
    motion = t_pose(path)
    simulator = Simulator(press("from behind"), body=body, settings=as_it_is(), fps=30.0)
    simulator.reset(motion[0])
    frames = [simulator.step(motion[t]) for t in range(1, FRAMES)]
    lost = np.array([f.lost_time for f in frames])
    assert lost.sum() > 0.1
    assert lost[-5:].sum() == 0.0
    assert frames[-1].pose.translation[2] == pytest.approx(path[-1, 2], abs=0.05)
    assert np.diff([f.objects["wall"][0][0] for f in frames])[-4:] == pytest.approx(0.04, abs=1e-9)
    turns = np.array([f.pose.rotations[1:] for f in frames])
    assert np.abs(turns[-1]).max() < 0.05


def test_a_wall_without_another_pushes_as_before(body):
    """A body with room to move is pushed at full speed, at any mass ratio."""
    frames = crush(body, "from behind", stop=False, speed=10.0)
    assert sum(f.lost_time for f in frames) == 0.0
    assert frames[-1].objects["wall"][0][0] == pytest.approx(-1.0 + 10.0 * 59 / 30, abs=1e-9)


def test_a_ball_between_walls_stops_the_one_that_comes():
    scene = Scene(gravity=0.0)
    scene.add_static("stop", Box((0.1, 2, 2)), position=(0.35, 0, 0))
    path = np.zeros((31, 3))
    path[:, 0] = -0.5 + np.arange(31) / 30.0
    scene.add_moving("wall", Box((0.1, 2, 2)), path, fps=30.0)
    scene.add_object("ball", Sphere(0.1), mass=2.0)
    simulator = Simulator(scene, body=[], fps=30.0)
    simulator.reset([])
    frames = [simulator.step([]) for _ in range(30)]
    gap = 0.3 - 2 * 0.1 - (frames[-1].objects["wall"][0][0] + 0.05)
    assert 0.0 < gap < 0.003
    assert abs(frames[-1].objects["ball"][0][0] - 0.2) < 0.002


def test_a_state_in_the_middle_goes_on_to_the_bit(body):
    motion = t_pose(np.zeros((FRAMES, 3)))
    runs = []
    for _ in range(2):
        simulator = Simulator(press("from behind"), body=body, settings=as_it_is(), fps=30.0)
        simulator.reset(motion[0])
        runs.append(simulator)
    a, b = runs
    for t in range(1, 40):
        frame = a.step(motion[t])
    assert frame.lost_time > 0.0
    b.set_state(a.get_state())
    for t in range(40, 50):
        x, y = a.step(motion[t]), b.step(motion[t])
        np.testing.assert_array_equal(x.pose.rotations, y.pose.rotations)
        np.testing.assert_array_equal(x.objects["wall"][0], y.objects["wall"][0])
        assert x.lost_time == y.lost_time


def test_one_warning_names_the_time_and_the_things(body):
    with pytest.warns(HalfPhysicsWarning, match=r"no room from 0\.\d+ to 1\.97 s") as said:
        result = simulate(t_pose(np.zeros((FRAMES, 3))), press("from behind"), body=body)
    (one,) = said
    assert "'wall'" in str(one.message)
    assert "'stop'" in str(one.message)
    assert one.filename == __file__
    assert f"{result.lost_time.sum():.2g} s were lost" in str(one.message)
