"""Friction that the solver did not settle is said, frame by frame; and how much there is of it."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import scenarios
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.as_it_is import as_it_is
from support.people import along_x

#: Tolerances of the solver that do where friction is slow to settle (tuning.h, kEnough).
ENOUGH = 5.0
SUBSTEPS = 8
#: Limp bodies are pressed flat by Algorithm 1: dozens of redundant points, some near jamming.
CASES = {
    "default": Settings(substeps=SUBSTEPS),
    "as it is": as_it_is(substeps=SUBSTEPS),
    "Algorithm 1": Settings.paper(1.0, substeps=SUBSTEPS),
    "Algorithm 1, limp": Settings.paper(0.0, substeps=SUBSTEPS),
}


def wall():
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.5, 0.0, 0.0))
    scene.add_static("floor", Plane(), position=(0.0, 0.0, -2.0))
    return scene


@pytest.mark.parametrize("case", CASES)
def test_friction_settles(case):
    """A T-pose walks into a wall and presses on for a second and a half."""
    settings = CASES[case]
    motion = along_x(1.5, 60, start=-0.4)
    result = simulate(motion, wall(), body=Body.default(), settings=settings)
    found = result.diagnostics
    missed, tolerances = found["friction_residual"], found["friction_tolerances"]
    assert found["contacts"].max() > 15
    # The tolerance is a way in a substep; as a velocity it depends on the substep's length.
    whole = found["shortened"] == 0
    speed = settings.tolerance * motion.fps * SUBSTEPS
    np.testing.assert_allclose(missed[whole], tolerances[whole] * speed, rtol=1e-9)
    assert tolerances.max() > 0.0
    assert tolerances.max() <= ENOUGH
    assert "friction missed" not in result.summary()


@pytest.mark.parametrize("start", [-0.41, -0.43, -0.45])
def test_friction_settles_wherever_the_motion_starts(start):
    """Before paths (coulomb_path.h), one of these was left 3,235 tolerances off, another 3,150."""
    motion = along_x(1.5, 60, start=start)
    result = simulate(motion, wall(), body=Body.default(), settings=CASES["as it is"])
    assert result.diagnostics["contacts"].max() > 15
    assert result.diagnostics["friction_tolerances"].max() <= ENOUGH


@pytest.mark.parametrize("name", scenarios.names())
def test_friction_settles_in_every_scenario(name):
    """Walls, grips, drawers, beds, two people."""
    sequence = scenarios.load(name)
    result = simulate(
        sequence.motions, sequence.scene, body=sequence.bodies, settings=sequence.settings
    )
    assert len(result.contacts) > 0
    assert result.diagnostics["friction_tolerances"].max() <= ENOUGH
