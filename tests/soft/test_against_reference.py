"""Trajectories against an integrator that shares no code with the core: support/soft/winkler.py."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Sphere
from support.soft import winkler
from support.soft.scenes import LYING, on_floor, run, soft
from support.soft.winkler import Layer, State

MASS = 5.0


def compared(shape, body, layer, start, seconds, fps=120.0, substeps=8):
    """Positions (T, 3) [m] and quaternions (T, 4) of both at the frames: ours, theirs."""
    scene = on_floor(
        soft(layer.stiffness, layer.damping, thickness=0.2),
        shape,
        0.0,
        MASS,
        friction=layer.friction,
        position=start.position,
        quaternion=start.quaternion,
        velocity=start.velocity,
        angular_velocity=start.spin,
    )
    result = run(scene, seconds, fps, substeps)
    times = result.times[::substeps]
    states = winkler.follow(body, layer, start, times, accuracy=1e-6)
    theirs = np.array([s.position for s in states]), np.array([s.quaternion for s in states])
    return (result.poses[::substeps, :3], result.poses[::substeps, 3:]), theirs


def differences(ours, theirs):
    """Largest distance [m] and angle [rad]."""
    off = np.linalg.norm(ours[0] - theirs[0], axis=1).max()
    both = rot.multiply(rot.conjugate(theirs[1]), ours[1])
    return off, np.linalg.norm(rot.log(rot.normalize(both)), axis=-1).max()


def state(height, turn=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0)):
    return State(
        np.array([0.0, 0.0, height]), rot.exp(np.array(turn)), np.array(velocity), np.array(spin)
    )


BOX = (0.3, 0.3, 0.2)


@pytest.mark.parametrize("damping", [0.0, 600.0])
def test_a_ball_bounces(damping):
    ours, theirs = compared(
        Sphere(0.12), winkler.ball(MASS, 0.12, 60), Layer(2e5, damping), state(0.3), 0.9
    )
    lowest = 0.12 - theirs[0][:, 2].min()
    assert lowest > 0.02
    off, _ = differences(ours, theirs)
    assert off < 0.01 * 0.3


def test_a_box_rocks():
    """Let go tilted by 5 degrees with its whole face in the layer: it rocks about the level."""
    layer = Layer(5e4, 0.0, 0.0)
    start = state(0.1 - 0.03, (0.0, np.radians(5.0), 0.0))
    ours, theirs = compared(Box(BOX), winkler.box(MASS, BOX, 24), layer, start, 0.8)
    off, turned = differences(ours, theirs)
    assert off < 0.001
    # Late by 1 % of a period after three of them is 0.19 of the amplitude.
    assert turned < 0.19 * np.radians(5.0)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_tilted_box_lands_and_settles(friction):
    """On an edge, then on its face: place and turn at every frame of the landing."""
    layer = Layer(1e5, 1500.0, friction)
    start = state(0.25, (0.15, 0.3, 0.0), (0.4, 0.0, 0.0))
    ours, theirs = compared(Box(BOX), winkler.box(MASS, BOX, 24), layer, start, 0.6)
    off, turned = differences(ours, theirs)
    # Friction acts at four points of the core's and everywhere in the reference: what it adds to a
    # spin is another by a few per cent, and then it rocks for half a second.
    assert off < (0.02 if friction else 0.01)
    assert turned < (0.16 if friction else 0.03)


def test_a_box_falls_over():
    """Tall, with a push: it rolls over its edge and comes to rest on its side."""
    size = (0.12, 0.2, 0.4)
    layer = Layer(2e5, 3e3, 0.8)
    start = state(0.2 - 0.005, spin=(0.0, 2.2, 0.0))
    ours, theirs = compared(Box(size), winkler.box(MASS, size, 24), layer, start, 1.2)
    # It is unstable: a late tip is the same fall. Both lie in the end, at the same place.
    assert abs(rot.log(theirs[1][-1])[1]) == pytest.approx(np.pi / 2, abs=0.05)
    assert rot.log(ours[1][-1])[1] == pytest.approx(rot.log(theirs[1][-1])[1], abs=0.02)
    assert np.linalg.norm(ours[0][-1] - theirs[0][-1]) < 0.015


def test_a_cylinder_rolls():
    """Friction turns a slide into a roll."""
    layer = Layer(2e6, 0.0, 0.4)
    start = State(np.array([0.0, 0.0, 0.1 - 0.002]), LYING, np.array([1.0, 0.0, 0.0]), np.zeros(3))
    body = winkler.cylinder(MASS, 0.1, 0.3, 180)
    ours, theirs = compared(Cylinder(0.1, 0.3), body, layer, start, 0.5)
    assert ours[0][-1, 0] == pytest.approx(theirs[0][-1, 0], rel=0.02)
    speed = np.diff(ours[0][-3:, 0]).mean() * 120.0
    assert speed == pytest.approx(2.0 / 3.0, rel=0.05)
