"""The plain integrator obeys its closed forms: force, sink, period, energy, rolling, spin."""

from __future__ import annotations

import numpy as np
import pytest

from support.soft import closed_forms as forms
from support.soft import winkler
from support.soft.winkler import Layer, State

UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
LYING = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
STILL = np.zeros(3)


def at(height, turn=UPRIGHT, velocity=STILL, spin=STILL):
    return State(np.array([0.0, 0.0, height]), turn, np.asarray(velocity), np.asarray(spin))


def test_quadrature_of_areas_and_inertia():
    one = winkler.box(2.0, (0.2, 0.3, 0.4))
    assert one.surface.areas.sum() == pytest.approx(2 * (0.06 + 0.08 + 0.12))
    assert one.inertia == pytest.approx(2.0 / 12.0 * np.array([0.25, 0.2, 0.13]))
    assert winkler.ball(1.0, 0.1).surface.areas.sum() == pytest.approx(4 * np.pi * 0.01)
    can = winkler.cylinder(1.0, 0.1, 0.3).surface
    assert can.areas.sum() == pytest.approx(2 * np.pi * 0.1 * 0.4, rel=1e-6)
    for shape in (one.surface, can, winkler.ball(1.0, 0.1).surface):
        assert np.abs((shape.areas[:, None] * shape.normals).sum(axis=0)).max() < 1e-12


def test_forces():
    layer, depth = Layer(1e5), 0.03
    force = winkler.pressed(winkler.ball(1.0, 0.2, bands=200), layer, at(0.2 - depth))[0]
    assert force[2] == pytest.approx(forms.ball_force(1e5, 0.2, depth), rel=5e-3)
    can = winkler.cylinder(1.0, 0.1, 0.4, around=720)
    force = winkler.pressed(can, layer, at(0.1 - depth, LYING))[0]
    assert force[2] == pytest.approx(forms.cylinder_force(1e5, 0.1, 0.4, depth), rel=5e-3)
    force, moment, stored = winkler.pressed(
        winkler.box(1.0, (0.4, 0.2, 0.1)), layer, at(0.05 - depth)
    )
    assert force[2] == pytest.approx(1e5 * 0.08 * depth)
    assert stored == pytest.approx(0.5 * 1e5 * 0.08 * depth**2)
    assert np.abs(moment).max() < 1e-10


def test_a_box_settles_by_its_closed_form():
    k, c, mass = 2e4, 1.5e3, 10.0
    times = np.linspace(0.0, 1.5, 61)
    body = winkler.box(mass, (0.4, 0.4, 0.2), across=4)
    states = winkler.follow(body, Layer(k, c), at(0.1), times)
    depth = np.array([0.1 - s.position[2] for s in states])
    np.testing.assert_allclose(depth, forms.settling(k, c, 0.16, mass, times), atol=1e-6)


def test_energy_is_kept_without_damping_and_friction():
    """A box that lands on a corner and tumbles: kinetic, of height and elastic, together.

    A layer so stiff that no edge above a face goes under: what is under an overhang is pressed by
    nothing, and the energy that it had is lost.
    """
    body, layer = winkler.box(3.0, (0.3, 0.2, 0.25), across=40), Layer(1e6)
    start = at(0.3, np.array([0.9, 0.3, 0.2, 0.1]), (0.5, 0.0, -1.0), (1.0, 2.0, 0.5))
    states = winkler.follow(body, layer, start, np.linspace(0.0, 0.4, 41), accuracy=1e-6)
    energies = [winkler.energy(body, layer, state) for state in states]
    assert max(winkler.pressed(body, layer, s)[2] for s in states) > 0.5
    # Points enter and leave the layer one by one.
    np.testing.assert_allclose(energies, energies[0], rtol=5e-3)


def test_a_sliding_ball_ends_rolling_at_five_sevenths():
    k, mass, radius = 3e6, 2.0, 0.1
    body = winkler.ball(mass, radius, bands=80)
    depth = forms.sink(lambda d: forms.ball_force(k, radius, d), mass * forms.G, 0.1)
    start = at(radius - depth, UPRIGHT, (2, 0, 0))
    layer = Layer(k, friction=0.5)
    end = winkler.follow(body, layer, start, np.array([0.0, 0.5]), accuracy=1e-5)[-1]
    # It rolls on a patch that is nearer than R: slip is zero somewhere in it.
    assert end.velocity[0] == pytest.approx(2.0 * 5.0 / 7.0, rel=0.03)
    assert end.spin[1] * radius == pytest.approx(end.velocity[0], rel=0.06)


def test_a_free_spin_keeps_its_angular_momentum():
    body = winkler.box(1.0, (0.1, 0.2, 0.4), across=2)
    spin = np.array([0.5, 9.0, 0.3])
    states = winkler.follow(
        body, Layer(1e4, gravity=(0, 0, 0)), at(5.0, UPRIGHT, STILL, spin), np.array([0.0, 3.0])
    )
    turn = winkler.matrix(states[-1].quaternion)
    momentum = turn @ (body.inertia * (turn.T @ states[-1].spin))
    np.testing.assert_allclose(momentum, body.inertia * spin, atol=1e-6)
