"""Friction of a patch: what spins, slides and is turned, by closed forms and by sums over areas."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Cylinder, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator
from support.spins import FRICTION, GAP, SHAPES, G, spin_of

#: Deceleration of a spin by closed forms [-].
SPIN = 0.02


@pytest.mark.parametrize("on", ["plane", "box", "mesh", "object"])
@pytest.mark.parametrize("name", SHAPES)
def test_a_spin_ends_by_the_moment_of_uniform_pressure(name, on):
    """alpha = mu g * (mean distance) / k^2; with friction at the rim 1.5 to 1.9 times that."""
    for yaw in (0.0, 0.4):
        assert spin_of(name, on=on, yaw=yaw) == pytest.approx(1.0, abs=SPIN)


@pytest.mark.parametrize("name", ["disc", "square", "2:1"])
@pytest.mark.parametrize(
    ("size", "fps", "substeps"), [(0.01, 480, 1), (0.05, 240, 1), (2.0, 30, 2)]
)
def test_a_spin_of_any_size_at_any_rate(name, size, fps, substeps):
    ratio = spin_of(name, size=size, fps=fps, substeps=substeps)
    assert ratio == pytest.approx(1.0, abs=SPIN)


@pytest.mark.parametrize("name", ["disc", "square"])
def test_a_spin_on_a_turned_floor(name):
    turn = rot.exp([0.5, -0.3, 0.2])
    assert spin_of(name, turn=turn) == pytest.approx(1.0, abs=SPIN)


def coupled(radius, speed, spin, seconds, h=1e-4):
    """Speed and spin of a disc that slides and spins, by the sum of friction over its area."""
    r, a = np.meshgrid((np.arange(40) + 0.5) / 40 * radius, 2 * np.pi * (np.arange(80) + 0.5) / 80)
    x, y, weight = r * np.cos(a), r * np.sin(a), r / r.sum()
    for _ in range(round(seconds / h)):
        vx, vy = speed - spin * y, spin * x
        size = np.hypot(vx, vy) + 1e-9
        force = -FRICTION * G * np.array([(weight * vx / size).sum(), (weight * vy / size).sum()])
        moment = -FRICTION * G * (weight * (x * vy - y * vx) / size).sum()
        speed, spin = speed + h * force[0], spin + h * moment / (0.5 * radius**2)
    return speed, spin


@pytest.mark.parametrize(("speed", "spin"), [(0.8, 2.0), (0.5, 8.0), (0.2, 12.0)])
def test_a_disc_that_slides_and_spins(speed, spin):
    """Friction of the one weakens the other (Farkas et al., Phys. Rev. Lett. 90, 248302): four
    points at two thirds of the radius are within 12 % of the area."""
    radius, seconds = 0.1, 0.1
    scene = Scene()
    scene.add_static("floor", Plane(), friction=FRICTION)
    scene.add_object(
        "disc",
        Cylinder(radius, 0.01),
        mass=1.0,
        friction=FRICTION,
        position=(0, 0, 0.005 + GAP),
        velocity=(speed, 0, 0),
        angular_velocity=(0, 0, spin),
    )
    simulator = Simulator(scene, body=[], settings=Settings(), fps=120)
    simulator.reset([])
    for _ in range(round(seconds * 120)):
        simulator.step([])
    v = simulator.world.stepper.qvel()
    expected = coupled(radius, speed, spin, seconds)
    assert np.hypot(v[0], v[1]) == pytest.approx(expected[0], abs=0.12 * speed)
    assert v[5] == pytest.approx(expected[1], abs=0.12 * spin)


@pytest.mark.parametrize("yaw", [0.0, 0.3, 1.1])
def test_sliding_without_spin_stays_without(yaw):
    """All points slide one way: their friction acts at the centre of pressure, wherever that is."""
    scene = Scene()
    scene.add_static("floor", Plane(), friction=FRICTION)
    scene.add_object(
        "brick",
        Box((0.3, 0.2, 0.15)),
        mass=2.0,
        friction=FRICTION,
        position=(0, 0, 0.075 + GAP),
        quaternion=rot.exp([0.0, 0.0, yaw]),
        velocity=(2.0, 0, 0),
    )
    simulator = Simulator(scene, body=[], settings=Settings(), fps=60)
    simulator.reset([])
    for k in range(1, 31):
        simulator.step([])
        v = simulator.world.stepper.qvel()
        assert v[0] == pytest.approx(2.0 - FRICTION * G * k / 60.0, rel=1e-3)
        assert abs(v[5]) < 0.01
        assert abs(v[1]) < 2e-3


def test_momentum_of_two_that_rub_is_kept():
    """A spinning box meets another with no gravity: what contacts change of linear and of angular
    momentum is nothing, as friction acts on both at one place."""
    scene = Scene(gravity=0.0)
    common = {"mass": 1.0, "friction": 0.6}
    low, high = Box((0.4, 0.3, 0.1)), Box((0.2, 0.1, 0.1))
    scene.add_object("low", low, position=(0, 0, 0), **common)
    scene.add_object(
        "high",
        high,
        position=(0.05, 0.04, 0.12),
        velocity=(0.2, 0.0, -0.5),
        angular_velocity=(0, 0, 9.0),
        **common,
    )
    simulator = Simulator(scene, body=[], settings=Settings(), fps=240)
    simulator.reset([])
    stepper = simulator.world.stepper
    stepper.keep_trace(True)
    inertia = [np.array(scene.objects[name].inertia) for name in ("low", "high")]
    drawn = 0.0
    for _ in range(30):
        simulator.step([])
        trace = stepper.trace()
        drawn = max(drawn, np.abs(trace["contacts"]["inward"]).max(initial=0.0))
        linear, angular = np.zeros(3), np.zeros(3)
        change = (trace["v"] - trace["v_free"]).reshape(2, 6)
        for x, dv, own in zip(trace["qpos"].reshape(2, 7), change, inertia, strict=True):
            linear += dv[:3]
            angular += np.cross(x[:3], dv[:3]) + rot.to_matrix(x[3:]) @ own @ dv[3:]
        np.testing.assert_allclose(linear, 0.0, atol=1e-12)
        np.testing.assert_allclose(angular, 0.0, atol=1e-12)
    assert drawn > 0.01
    assert abs(stepper.qvel()[5]) > 0.1  # the one has turned the other


def test_a_point_alone_has_its_friction_where_it_is():
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.5)
    scene.add_object("ball", Sphere(0.1), mass=1.0, position=(0, 0, 0.101), velocity=(1, 0, 0))
    simulator = Simulator(scene, body=[], settings=Settings(), fps=60)
    simulator.reset([])
    simulator.world.stepper.keep_trace(True)
    simulator.step([])
    trace = simulator.world.stepper.trace()["contacts"]
    assert len(trace["dist"]) == 1
    assert not trace["inward"].any()


def test_places_lie_in_the_plane_and_within_the_patch():
    """Of a box at rest: 0.541 of its corners' distance."""
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.5)
    scene.add_object("box", Box((0.2, 0.2, 0.2)), mass=1.0, position=(0, 0, 0.101))
    simulator = Simulator(scene, body=[], settings=Settings(), fps=60)
    simulator.reset([])
    simulator.world.stepper.keep_trace(True)
    for _ in range(5):
        simulator.step([])
    trace = simulator.world.stepper.trace()["contacts"]
    corners = trace["points_a"][:, 0]
    places = corners + trace["inward"]
    np.testing.assert_allclose(places[:, 2], corners[:, 2], atol=1e-15)
    spread = SHAPES["square"][1] / np.sqrt(0.5)
    np.testing.assert_allclose(places[:, :2], spread * corners[:, :2], atol=1e-6)
