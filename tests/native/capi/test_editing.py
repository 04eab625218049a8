"""What changes while a world runs: masses, friction, velocities, stiffness, as in Python."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.c_library import CError, CWorld

REST = hp.Pose((0, 0, 5.0), np.zeros((55, 3)))


def block(mass=2.0, friction=0.5, **options):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(), friction=0.6)
    size = (0.1, 0.2, 0.1)
    scene.add_object(
        "block", hp.Box(size), mass=mass, friction=friction, position=(0, 0, 0.101), **options
    )
    return scene


def pair(scene):
    """The scene without people, reset, in Python and in C."""
    sim = hp.Simulator(scene, body=[])
    world = CWorld(hp.compile_world(scene, body=[]))
    sim.reset([])
    world.reset()
    return sim, world


def test_impulses_and_velocities_are_those_of_python():
    sim, world = pair(block(com=(0.02, 0.0, 0.01)))
    push, point = np.array([3.0, 1.0, 0.2]), np.array([0.05, 0.1, 0.15])
    sim.apply_impulse("block", push, point)
    world.call("apply_impulse", "block", push, point)
    for ours, theirs in zip(world.velocity("block"), sim.velocity("block"), strict=True):
        assert np.abs(ours - theirs).max() < 1e-12
    sim.set_velocity("block", (0, 2.0, 0), (0.5, 0, 1.0))
    world.call("set_velocity", "block", np.array([0, 2.0, 0]), np.array([0.5, 0, 1.0]))
    for ours, theirs in zip(world.velocity("block"), sim.velocity("block"), strict=True):
        assert np.array_equal(ours, theirs)
    sim.set_velocity("block", (1.0, 0, 0))
    world.call("set_velocity", "block", np.array([1.0, 0, 0]), None)
    frame = sim.step([])
    world.step(dt=sim.dt)
    assert np.array_equal(world.object("block")[0], frame.objects["block"][0])


def slide(world, frames=40):
    """How far the block slides that lies there and is given 2 m/s."""
    for _ in range(10):
        world.step(dt=1 / 30)
    world.call("set_velocity", "block", np.array([2.0, 0, 0]), np.zeros(3))
    for _ in range(frames):
        world.step(dt=1 / 30)
    return world.object("block")[0][0]


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.9])
def test_friction_stops_a_block_as_coulomb_says(friction):
    _, world = pair(block())
    world.call("set_friction", "block", friction)
    least = min(friction, 0.6)  # the floor's
    # v^2 / (2 mu g), with steps of 1/240 s.
    assert slide(world, 200) == pytest.approx(4.0 / (2 * least * 9.81), rel=0.03)


def test_friction_is_that_of_a_scene_made_with_it():
    worlds = [pair(block(friction=mu))[1] for mu in (0.5, 0.2)]
    worlds[0].call("set_friction", "block", 0.2)
    assert slide(worlds[0]) == slide(worlds[1])


def test_a_mass_is_that_of_a_scene_made_with_it():
    _, world = pair(block(mass=2.0))
    _, made = pair(block(mass=7.0))
    world.call("set_mass", "block", 7.0)
    assert world.number("get_mass", "block") == 7.0
    for one in (world, made):
        one.call("apply_impulse", "block", np.array([14.0, 0, 0]), np.array([0, 0.1, 0.1]))
    for ours, theirs in zip(world.velocity("block"), made.velocity("block"), strict=True):
        assert np.abs(ours - theirs).max() < 1e-12
    assert world.velocity("block")[0][0] != 0.0
    for _ in range(10):
        for one in (world, made):
            one.step(dt=1 / 30)
    assert np.abs(world.object("block")[0] - made.object("block")[0]).max() < 1e-9


def test_stiffness_is_that_of_python():
    sequence = hp.scenarios.load("lift_suitcase")
    motion = sequence.motion[60:80]
    sim = hp.Simulator(sequence.scene, settings=sequence.settings, fps=motion.fps)
    world = CWorld(hp.compile_world(sequence.scene, settings=sequence.settings))
    world.call("set_axes", 0, np.array(motion.axes, dtype=np.float64))
    sim.reset(motion[0])
    world.reset(motion[0])
    soft = np.linspace(0.5, 2.0, 55)
    sim.set_stiffness(soft)
    world.call("set_stiffness", -1, soft)
    touched = 0
    for i in range(1, len(motion)):
        frame = sim.step(motion[i])
        world.step(motion[i], dt=sim.dt)
        touched += len(frame.contacts.part)
    assert touched > 0
    assert np.array_equal(world.pose()[1], frame.pose.rotations)


@pytest.mark.parametrize(
    ("call", "status", "says"),
    [
        (("set_mass", "ball", 1.0), 3, "nothing called 'ball'; objects: block"),
        (("set_mass", "floor", 1.0), 3, "'floor' does not move freely"),
        (("set_mass", "block", 0.0), 1, "mass: found 0"),
        (("set_mass", "block", np.inf), 1, "mass: found inf"),
        (("set_friction", "block", -0.1), 1, "found -0.1"),
        (("set_friction", "flor", 0.5), 3, "nothing called 'flor'"),
        (("set_stiffness", 0, np.ones(55)), 3, "no such person"),
        (("apply_impulse", "block", np.array([np.nan, 0, 0]), None), 1, "impulse: found nan"),
        (("set_velocity", "block", None, None), 1, "velocity is NULL"),
        (("set_axes", 0, np.eye(3)), 3, "no such person"),
    ],
)
def test_mistakes_are_named(call, status, says):
    _, world = pair(block())
    with pytest.raises(CError, match=says) as caught:
        world.call(*call)
    assert caught.value.status == status


def test_axes_must_be_a_rotation():
    world = CWorld(hp.compile_world())
    with pytest.raises(CError, match="rotation matrix"):
        world.call("set_axes", 0, np.diag([1.0, 1.0, -1.0]))
    world.call("set_axes", 0, np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    world.reset(REST)
    assert world.pose()[0] == pytest.approx(REST.translation)
