"""Contacts and bodies of the C library are those of `Simulator`."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.c_library import CError, CWorld


@pytest.fixture(scope="module")
def met():
    """Two people whose hands meet: the frame in Python, the world in C."""
    sequence = hp.scenarios.load("shake_hands")
    motions = [m[86:100] for m in sequence.motions]
    sim = hp.Simulator(sequence.scene, body=list(sequence.bodies), fps=motions[0].fps)
    world = CWorld(hp.compile_world(sequence.scene, body=list(sequence.bodies)))
    for i, motion in enumerate(motions):
        world.call("set_axes", i, np.array(motion.axes, dtype=np.float64))
    sim.reset([m[0] for m in motions])
    world.reset(*(m[0] for m in motions))
    for i in range(1, len(motions[0])):
        frame = sim.step([m[i] for m in motions])
        world.step(*(m[i] for m in motions), dt=sim.dt)
        rows = frame.contacts
        if (rows.other_part >= 0).any():
            return frame, world, sim
    raise AssertionError("they never touch")


def test_contacts_are_those_of_python(met):
    frame, world, sim = met
    found, rows = world.contacts(), frame.contacts
    for column in ("person", "part", "subject", "other", "other_part"):
        assert np.array_equal(found[column], getattr(rows, column)), column
    for column in ("position", "normal", "impulse"):
        assert np.array_equal(found[column], getattr(rows, column)), column
    assert np.allclose(found["force"], rows.impulse / sim.dt, rtol=1e-12)
    assert list(sim.names) == world.names


def test_bodies_are_frames_of_joints(met):
    frame, world, sim = met
    bodies = world.bodies()[:110].reshape(2, 55, 7)
    for i, (pose, body) in enumerate(zip(frame.poses, sim.bodies, strict=True)):
        twice = (np.stack([v, v]) for v in (pose.translation, pose.rotations))
        motion = hp.Motion(*twice, fps=30, axes=pose.axes)
        assert np.abs(bodies[i, :, :3] - body.joints(motion)[0]).max() < 1e-12


def test_what_there_is_not_is_named(met):
    _, world, _ = met
    with pytest.raises(CError, match="nothing called 'ball'"):
        world.object("ball")
    with pytest.raises(CError, match="is no object and no link"):
        world.object("person0")
    with pytest.raises(CError, match="no such person"):
        world.pose(2)


def test_joints_of_a_door():
    sequence = hp.scenarios.load("push_door")
    world = CWorld(hp.compile_world(sequence.scene, settings=sequence.settings))
    sim = hp.Simulator(sequence.scene, settings=sequence.settings, fps=sequence.motion.fps)
    sim.reset(sequence.motion[0])
    world.call("set_axes", 0, np.array(sequence.motion.axes, dtype=np.float64))
    world.reset(sequence.motion[0])
    for i in range(1, len(sequence.motion)):
        frame = sim.step(sequence.motion[i])
        world.step(sequence.motion[i], dt=sim.dt)
    (value,) = frame.joints.values()
    out, count = np.zeros(7), np.zeros(1, dtype=np.int32)
    world.call("get_joint", 0, out, count)
    assert count[0] == 1
    assert out[0] == value
    assert abs(value) > 0.1
