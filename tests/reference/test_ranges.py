"""Rows of joints' ranges: the native core's against the plain numpy ones, substep by substep."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.body.joint_ranges import JointRanges, swing_twist
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.reference import ranges
from halfphysics.reference import step as reference
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import along_x

VELOCITY = 5e-9
ANGLE = 1e-10


@pytest.fixture(scope="module")
def body():
    return Body.default()


def test_angles_and_rates(body):
    """Two ways to the same angles; the rates are theirs."""
    rng = np.random.default_rng(0)
    axes = JointRanges.of(body).axes
    for quat in rot.exp(rng.normal(size=(100, 3))):
        frame = axes[rng.integers(1, 55)]
        np.testing.assert_allclose(
            ranges.joint_angles(quat, frame), swing_twist(quat, frame), atol=1e-12
        )
        turn = 1e-5 * rng.normal(size=3)
        before, after = (
            swing_twist(rot.multiply(quat, rot.exp(s * turn)), frame) for s in (-0.5, 0.5)
        )
        np.testing.assert_allclose(
            ranges.angle_rates(quat, frame) @ turn, after - before, atol=1e-11
        )


@pytest.mark.parametrize("drive", [0.02, None])
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_velocities_with_ranges_are_equal(body, drive, stiffness):
    """A person walks into a wall, toes in the floor: which ends, what they demand, and the velocity
    that rows and contacts make."""
    motion = along_x(1.5, 24, start=0.1).grounded(body, 0.0005).resample(240.0)
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=0.3)
    scene.add_static("floor", Plane(), friction=0.5)
    settings = as_it_is(
        drive_time=drive, stiffness=stiffness, substeps=1, contact="parts", joint_limits=True
    )
    dt = 1.0 / 240.0
    simulator = Simulator(scene, body=body, settings=settings, fps=240)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    person = simulator.world.people[0]
    of = JointRanges.of(body)
    axes, lower, upper = (v[person.balls] for v in (of.axes, of.lower, of.upper))
    stepper.keep_trace(True)
    targets = simulator.world.motion_coordinates([motion])
    dof = int(model.jnt_dofadr[model.body_jntadr[person.root]])
    own = reference.ReferenceDrive(settings, person.qpos, dof, targets[0])
    rows = 0
    for t in range(1, len(motion)):
        qpos = np.array(stepper.qpos())
        simulator.step(motion[t])
        trace = stepper.trace()
        found = trace["ranges"]
        if len(found["dist"]) == 0:
            continue
        for i, (ball, axis) in enumerate(zip(found["ball"], found["axis"], strict=True)):
            k, a = int(ball), int(axis)
            quats = [q[person.qpos + 3 + 4 * k :][:4] for q in (qpos, targets[t - 1], targets[t])]
            low, high = ranges.ends(lower[k], upper[k], axes[k], quats[1:])
            end = (low if found["sign"][i] > 0 else high)[a]
            assert found["limit"][i] == pytest.approx(end, abs=ANGLE)
            gap = found["sign"][i] * (ranges.joint_angles(quats[0], axes[k])[a] - end)
            assert found["dist"][i] == pytest.approx(ranges.LEVER * gap, abs=ANGLE)
            assert found["target"][i] == pytest.approx(ranges.demands(gap, dt), abs=ANGLE)
        M = reference.inertia_matrix(model, qpos)
        stiff = reference.stiff_diagonal(model, M, own)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])
        M = own.scale(dt) * (M + np.diag(held))
        points = ranges.joined(trace["contacts"], found, axes, model.nv)
        problem = reference.contact_problem(model, qpos, trace["v_free"], M, dt, points)
        np.testing.assert_allclose(trace["v"], problem.velocity(problem.found), atol=VELOCITY)
        rows += np.count_nonzero(found["impulse"])
    assert rows > 10
