"""Foam: hysteresis, creep, slow recovery, densification, by its equation integrated by scipy."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.simulation.simulator import Simulator
from support.soft.foam import Foam, creep, press
from support.soft.scenes import energies, on_floor, pressures, run, soft

MASS, SIZE = 6.0, (0.2, 0.2, 0.1)
AREA = SIZE[0] * SIZE[1]
FOAM = Foam(stiffness=4e4, damping=300.0, thickness=0.1, densification=4.0, arm=0.6, relaxation=0.2)


def layer(foam, **more):
    return soft(
        foam.stiffness,
        foam.damping,
        foam.thickness,
        law="foam",
        densification=foam.densification,
        hysteresis=foam.arm,
        recovery=foam.relaxation,
        **more,
    )


def dropped(foam, drop, seconds, mass=MASS, fps=120.0):
    return run(on_floor(layer(foam), Box(SIZE), 0.05 + drop, mass), seconds, fps=fps)


@pytest.mark.parametrize("drop", [0.0, 0.15])
def test_a_block_follows_the_equation(drop):
    result = dropped(FOAM, drop, 0.8)
    depth = 0.05 - result.height
    expected, *_ = press(FOAM, MASS, AREA, -drop, 0.0, result.times)
    assert depth.max() == pytest.approx(expected.max(), rel=0.01)
    np.testing.assert_allclose(depth, expected, atol=0.03 * (expected.max() + drop))


def test_the_loop_dissipates():
    """A rebound from foam is lower than from springs, by the work of the loop."""
    springs = Foam(4e4, 0.0, 0.1, 4.0, 0.0, 1.0)
    slow = Foam(4e4, 0.0, 0.1, 4.0, 0.6, 0.2)
    heights = []
    for foam in (springs, slow):
        scene = on_floor(layer(foam), Box(SIZE), 0.2, MASS)
        result = run(scene, 0.7, fps=120)
        energy = energies(result, scene)
        chord = MASS * 9.81 * 1.8 / 960.0  # g h of velocity, which a fall's chord may be off
        assert energy.max() <= energy[0] + chord
        late = result.times > 0.35
        heights.append(result.height[late].max() - 0.05)
    expected, *_ = press(slow, MASS, AREA, -0.15, 0.0, result.times)
    assert heights[0] == pytest.approx(0.15, rel=0.01)
    assert heights[1] == pytest.approx(-expected[late].min(), rel=0.02)
    assert heights[1] < 0.9 * heights[0]


def test_it_creeps_under_a_load():
    """From p / (k (1 + r)) to p / k with the time constant tau (1 + r)."""
    foam = Foam(4e4, 800.0, 0.1, 0.0, 0.6, 0.5)
    result = dropped(foam, 0.0, 3.0, mass=4.0, fps=30.0)
    depth = 0.05 - result.height
    late = result.times > 0.9
    expected = creep(foam, 4.0 * 9.81 / AREA, result.times)
    np.testing.assert_allclose(depth[late], expected[late], rtol=0.02)


def fallen_twice(foam, drop=0.1):
    """Deepest sinks [m] of a block that falls, rests for four seconds, and falls as far again."""
    simulator = Simulator(on_floor(layer(foam), Box(SIZE), 0.05 + drop, MASS), body=[], fps=60)
    simulator.reset([])
    height = [simulator.step([]).objects["thing"][0][2] for _ in range(240)]
    up = np.sqrt(2.0 * 9.81 * (0.05 + drop - height[-1]))
    simulator.set_velocity("thing", (0.0, 0.0, up), (0.0, 0.0, 0.0))
    again = [simulator.step([]).objects["thing"][0][2] for _ in range(60)]
    return 0.05 - min(height), 0.05 - min(again[int(np.argmax(again)) :])


def test_what_was_pressed_comes_back_slowly():
    """What falls into a dent that is left finds springs that have slackened: it goes deeper.

    Into foam without memory it goes as deep as before, but for what the throw is too high by.
    """
    first, second = fallen_twice(Foam(4e4, 300.0, 0.1, 0.0, 1.0, 3.0))
    assert second > 1.1 * first
    first, second = fallen_twice(Foam(4e4, 300.0, 0.1, 0.0, 0.0, 1.0))
    assert second == pytest.approx(first, rel=0.02)


def test_it_stiffens_towards_full_compression():
    """Ten times the load does not sink ten times as far: p = k d (1 + D (d/t)^4)."""
    for mass, damping in ((4.0, 3e3), (40.0, 2e4)):
        foam = Foam(4e4, damping, 0.1, 8.0, 0.0, 1.0)
        result = dropped(foam, 0.0, 2.0, mass=mass, fps=30.0)
        depth = 0.05 - result.height[-1]
        assert AREA * foam.springs(depth) == pytest.approx(mass * 9.81, rel=0.01)
        rows = pressures(result)
        np.testing.assert_allclose(rows.pressure, foam.springs(depth), rtol=0.01)
    assert depth < 0.095


def test_the_sofa_remembers_and_a_saved_state_too():
    """What a layer remembers is in the state: a simulator that takes over gives the same bits."""
    scene = on_floor(layer(FOAM), Box(SIZE), 0.15, MASS)
    one = run(scene, 0.4, fps=60).simulator
    other = run(scene, 0.1, fps=60).simulator
    other.set_state(one.get_state())
    for _ in range(20):
        a, b = one.step([]), other.step([])
        np.testing.assert_array_equal(a.substeps, b.substeps)


def test_what_has_bounced_rests_at_one_depth_with_any_substeps():
    def rests(substeps):
        scene = on_floor(hp.Soft.named("sofa"), Sphere(0.11), 0.6, mass=3.0)
        return run(scene, 3.0, substeps=substeps).height[-1]

    depths = [rests(n) for n in (4, 8, 16)]
    assert np.ptp(depths) < 0.0005
