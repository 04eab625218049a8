"""Period, damping and rebound on a layer, and the energy: by closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Sphere
from halfphysics.scene.scene import Scene
from support.soft import closed_forms as forms
from support.soft.scenes import LYING, energies, on_floor, run, soft

MASS, G, AREA = 10.0, forms.G, 0.16
BOX = Box((0.4, 0.4, 0.2))


@pytest.mark.parametrize("damping", [0.0, 300.0, 1000.0])
@pytest.mark.parametrize("stiffness", [2e4, 1e5])
def test_a_box_let_go_on_the_surface_settles_by_its_closed_form(stiffness, damping):
    """The whole curve within 1 % of the sink; period and decrement within 1 %."""
    result = run(on_floor(soft(stiffness, damping), BOX, 0.1), 2.0)
    depth = 0.1 - result.height
    expected = forms.settling(stiffness, damping, AREA, MASS, result.times)
    sink = MASS * G / (stiffness * AREA)
    first = result.times < 4.0 * 2.0 * np.pi / forms.frequency(stiffness, AREA, MASS)
    # A curve late by 1 % of a period after four of them is off by a quarter of its amplitude.
    np.testing.assert_allclose(depth[first], expected[first], atol=0.25 * sink)
    at, high = forms.peaks(result.times, depth)
    omega = forms.frequency(stiffness, AREA, MASS)
    zeta = forms.damping_ratio(stiffness, damping, AREA, MASS)
    if zeta > 0.3:
        return
    period = 2.0 * np.pi / (omega * np.sqrt(1.0 - zeta**2))
    assert np.diff(at)[:3] == pytest.approx(period, rel=0.01)
    decrement = np.exp(-zeta * omega * period)
    shrunk = (high[1:4] - sink) / (high[:3] - sink)
    assert shrunk == pytest.approx(decrement, rel=0.01)


@pytest.mark.parametrize("drop", [0.05, 0.5])
@pytest.mark.parametrize("stiffness", [3e4, 3e5])
def test_a_box_that_lands_flat_comes_back_with_what_it_had(stiffness, drop):
    """Without damping: depth, time in the layer and height of the rebound within 1 %."""
    result = run(on_floor(soft(stiffness, thickness=0.25), BOX, 0.1 + drop), 1.6, fps=120)
    speed = np.sqrt(2.0 * G * drop)
    depth = 0.1 - result.height
    deepest = forms.deepest(stiffness, AREA, MASS, speed)
    assert depth.max() == pytest.approx(deepest, rel=0.01)
    fall = speed / G
    into = np.flatnonzero((depth[:-1] <= 0.0) & (depth[1:] > 0.0))[0]
    came = np.interp(0.0, depth[into : into + 2], result.times[into : into + 2])
    stay = forms.contact_time(stiffness, AREA, MASS, speed)
    out = np.flatnonzero((depth[:-1] > 0.0) & (depth[1:] <= 0.0))[0]
    left = np.interp(0.0, -depth[out : out + 2], result.times[out : out + 2])
    assert left - came == pytest.approx(stay, rel=0.01)
    again = (result.times > left) & (result.times < left + 2.0 * fall)
    assert (result.height[again].max() - 0.1) == pytest.approx(drop, rel=0.01)


def test_damping_takes_what_its_equation_takes():
    """Height of the first rebound against an integration of the same equation."""
    from scipy.integrate import solve_ivp

    stiffness, damping, drop = 1e5, 800.0, 0.3

    def rates(_, y):
        d, v = y
        force = AREA * max(0.0, stiffness * d + damping * v) if d > 0.0 else 0.0
        return [v, G - force / MASS]

    done = solve_ivp(rates, (0.0, 1.0), [-drop, 0.0], max_step=1e-4, rtol=1e-8)
    result = run(on_floor(soft(stiffness, damping, 0.2), BOX, 0.1 + drop), 1.0, fps=120)
    late = np.sqrt(2.0 * drop / G) + 0.1
    expected = -done.y[0][done.t > late].min()
    assert (result.height[result.times > late].max() - 0.1) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("friction", [0.0, 0.7])
@pytest.mark.parametrize("damping", [0.0, 1000.0])
def test_energy_never_grows(damping, friction):
    """Random drops and spins of kinds of things; a layer without damping may give back."""
    rng = np.random.default_rng(3)
    # Of the plate springs alone are no potential: what is under an overhang is pressed by nothing.
    plate, box = Box((0.3, 0.3, 0.02)), Box((0.3, 0.2, 0.15))
    for shape in (box, Sphere(0.12), Cylinder(0.1, 0.25), Capsule(0.08, 0.3), plate):
        layer = soft(10.0 ** rng.uniform(4.3, 6.5), damping, thickness=0.2)
        scene = on_floor(
            layer,
            shape,
            0.5,
            mass=float(10.0 ** rng.uniform(-1.0, 1.5)),
            friction=friction,
            quaternion=rng.normal(size=4),
            velocity=rng.normal(size=3) * (2.0, 2.0, 2.0),
            angular_velocity=rng.normal(size=3) * 8.0,
        )
        result = run(scene, 1.5, fps=60)
        energy = energies(result, scene)
        assert np.isfinite(result.poses).all()
        # Of the parabola of a fall, chords: a velocity may be g h off.
        thing, fastest = scene.objects["thing"], np.abs(result.velocities[:, :3]).max()
        chord = thing.mass * G * fastest / 480.0
        assert energy.max() <= energy[0] + 0.01 * (energy[0] - energy.min()) + chord


def test_many_things_press_as_one_does():
    """A step's budget of work ends: whatever it leaves out, every layer pushes."""

    def rods(count):
        scene = Scene()
        scene.add_static("bed", Box((6.0, 2.0, 0.5)), position=(0, 0, -0.25), soft=soft(1e6))
        for i in range(count):
            place = {"position": (-2.5 + 0.3 * i, 0.0, 0.25), "quaternion": LYING}
            rod = {"mass": 2.0, "velocity": (0.0, 0.0, -5.0), "friction": 0.5}
            scene.add_object(f"rod{i}", Capsule(0.02, 0.6), **place, **rod)
        return run(scene, 0.5, fps=60).positions[:, :, 2]

    alone, together = rods(1), rods(12)
    assert alone.min() < -0.005
    np.testing.assert_allclose(together, np.broadcast_to(alone, together.shape), atol=0.001)
