"""Free things that meet through a layer: momentum, angular momentum and Newton's third law."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.scene.scene import Scene
from support.soft.scenes import run, soft

#: What rounding leaves of momentum, relative.
ROUNDING = 1e-10


def totals(result, scene):
    """Momentum (T, 3) and angular momentum (T, 3) about the origin, at the frames."""
    every = (len(result.poses) - 1) // (len(result.velocities) - 1)
    poses = result.poses[::every].reshape(len(result.velocities), -1, 7)
    rates = result.velocities.reshape(len(result.velocities), -1, 6)
    linear, angular = np.zeros((len(rates), 3)), np.zeros((len(rates), 3))
    for i, thing in enumerate(scene.objects.values()):
        turn = rot.to_matrix(poses[:, i, 3:])
        push = thing.mass * rates[:, i, :3]
        linear += push
        spin = np.einsum("tij,jk,tk->ti", turn, thing.inertia, rates[:, i, 3:])
        angular += np.cross(poses[:, i, :3], push) + spin
    return linear, angular


@pytest.mark.parametrize("both", [False, True], ids=["one soft", "both soft"])
@pytest.mark.parametrize("aside", [0.0, 0.06])
@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_two_balls_exchange_momentum(both, aside, friction):
    scene = Scene(gravity=0.0)
    layer = soft(3e5, 500.0, thickness=0.03)
    scene.add_object(
        "a", Sphere(0.1), mass=1.0, velocity=(2.0, 0.0, 0.0), friction=friction, soft=layer
    )
    scene.add_object(
        "b",
        Sphere(0.12),
        mass=3.0,
        position=(0.5, aside, 0.0),
        friction=friction,
        soft=layer if both else None,
    )
    result = run(scene, 0.6, fps=60)
    linear, angular = totals(result, scene)
    np.testing.assert_allclose(linear, np.tile([2.0, 0.0, 0.0], (len(linear), 1)), atol=ROUNDING)
    # A substep moves the points that are pressed: to first order in h.
    np.testing.assert_allclose(angular, np.tile(angular[0], (len(angular), 1)), atol=2e-3)
    hit = result.velocities.reshape(len(linear), 2, 6)[-1, 1, :3]
    assert hit[0] > 0.4


def test_a_head_on_hit_without_damping_is_elastic():
    """Speeds as of a perfectly elastic hit, within 1 %."""
    scene = Scene(gravity=0.0)
    layer = soft(1e5, thickness=0.05)
    scene.add_object("a", Sphere(0.1), mass=1.0, velocity=(1.0, 0.0, 0.0), friction=0.0)
    scene.add_object("b", Sphere(0.12), mass=3.0, position=(0.3, 0, 0), friction=0.0, soft=layer)
    result = run(scene, 0.8, fps=120)
    va, vb = result.velocities[-1].reshape(2, 6)[:, 0]
    assert va == pytest.approx(-0.5, abs=0.01)
    assert vb == pytest.approx(0.5, abs=0.01)


def test_what_a_contact_says_is_what_the_things_feel():
    """Newton's third law: impulses of the contacts explain both changes of momentum, exactly."""
    scene = Scene(gravity=0.0)
    scene.add_object("cushion", Box((0.5, 0.5, 0.2)), mass=2.0, soft=soft(3e4, 300.0, 0.06))
    scene.add_object(
        "brick",
        Box((0.2, 0.1, 0.1)),
        mass=3.0,
        position=(0.05, 0.03, 0.2),
        velocity=(0.3, 0.0, -1.0),
    )
    result = run(scene, 0.5, fps=60)
    names = result.simulator.names
    felt = 0.0
    for t, frame in enumerate(result.frames):
        c = frame.contacts
        for i, (name, thing) in enumerate(scene.objects.items()):
            index = names.index(name)
            gained = thing.mass * (
                result.velocities[t + 1, 6 * i : 6 * i + 3]
                - result.velocities[t, 6 * i : 6 * i + 3]
                - scene.gravity / 60.0
            )
            pushed = c.impulse[c.subject == index].sum(axis=0)
            pushed = pushed - c.impulse[c.other == index].sum(axis=0)
            np.testing.assert_allclose(gained, pushed, atol=1e-9)
            felt += np.linalg.norm(pushed)
    assert felt > 1.0


def test_two_soft_balls_are_springs_in_series():
    """Head on, both of stiffness k: pressed half as hard as one layer of k would be.

    Of two equal balls the deepest approach follows from the energy: at a small depth d the layers
    of stiffness k / 2 hold pi (k / 2) R' d^3 / 3, with 1 / R' = 2 / R.
    """
    k, radius, speed = 2e6, 0.1, 0.4
    scene = Scene(gravity=0.0)
    for name, x, v in (("a", -0.11, speed), ("b", 0.11, -speed)):
        scene.add_object(
            name,
            Sphere(radius),
            mass=1.0,
            position=(x, 0.0, 0.0),
            velocity=(v, 0.0, 0.0),
            friction=0.0,
            soft=soft(k, thickness=0.03),
        )
    result = run(scene, 0.2, fps=240, substeps=4)
    x = result.positions[:, :, 0]
    deepest = 2.0 * radius - (x[:, 1] - x[:, 0]).min()
    # Both move by their layer's share; samples are those of one ball against the other's field.
    expected = (speed**2 / (np.pi * 0.5 * k * 0.5 * radius / 3.0)) ** (1.0 / 3.0)
    assert deepest == pytest.approx(expected, rel=0.05)
