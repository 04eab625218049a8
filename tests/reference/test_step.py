"""The native substep against the plain numpy one, from the same state, substep by substep."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.body.body import Body
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.body.strength import limits_of
from halfphysics.geometry.shapes import Box, Plane, Sphere
from halfphysics.reference import step as reference
from halfphysics.reference.contact import contact_residual
from halfphysics.reference.ranges import joined
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulator import Simulator
from support.as_it_is import as_it_is
from support.people import along_x, violent

DRIVES = {"time constant": 0.02, "algorithm 1": None}
#: Both stop far below this; the rest is the conditioning of M (fingers of grams on 60 kg).
VELOCITY = 1e-9
TRAJECTORY = 1e-12
#: A limp arm, and a person easy to push: some joints yield without contact.
WEAK = {
    "right_shoulder": 0.0,
    "right_elbow": 0.0,
    "right_wrist": 2.0,
    "pelvis": 100.0,
    "root": 900.0,
}
#: Relative to up to 1000 N m: velocities to VELOCITY, times 60 kg and 240 Hz.
TORQUE = 1e-4


@pytest.fixture(scope="module")
def body():
    return Body.default()


def person_drive(simulator, settings, start):
    model, person = simulator.world.model, simulator.world.people[0]
    dof = int(model.jnt_dofadr[model.body_jntadr[person.root]])
    return reference.ReferenceDrive(settings, person.qpos, dof, start)


@pytest.mark.parametrize("drive", DRIVES)
def test_free_trajectories_are_equal(body, drive):
    motion = violent(frames=20)
    settings = as_it_is(drive_time=DRIVES[drive], stiffness=1.0)
    simulator = Simulator(Scene(), body=body, settings=settings, fps=30)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    targets = simulator.world.motion_coordinates([motion])
    own = person_drive(simulator, settings, targets[0])
    qpos, qvel = np.array(stepper.qpos()), np.array(stepper.qvel())
    h = 1.0 / 240.0
    M = reference.inertia_matrix(model, qpos)  # any M will do: deviations are zero in free motion
    stiff = reference.stiff_diagonal(model, M, own)
    for t in range(1, len(motion)):
        own.begin_frame(targets[t], 1.0 / 30.0, qpos, qvel)
        for k in range(8):
            qvel[own.dofs] = own.free_velocity(k, h, qpos, qvel, M, stiff)
            qpos = stepper.integrate(qpos, qvel, h)
            own.end_substep(qvel)
        simulator.step(motion[t])
        np.testing.assert_allclose(stepper.qpos(), qpos, atol=TRAJECTORY)


@pytest.mark.parametrize("contact", ["skin", "parts"])
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
@pytest.mark.parametrize("drive", DRIVES)
def test_velocities_with_contact_are_equal(body, drive, stiffness, contact):
    """A wall, the floor under the feet, a ball in the way: every fifth substep computed twice.

    The reference takes the state and the contact points of the core and computes the drive, M,
    J and the effect of the impulses itself.
    """
    motion = along_x(1.5, 24, start=-0.2).grounded(body, 0.0005)
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=0.3)
    scene.add_static("floor", Plane(), friction=0.5)
    scene.add_object("ball", Sphere(0.1), mass=0.5, position=(0.25, 0.2, 1.0), velocity=(-1, 0, 0))
    settings = as_it_is(contact=contact, drive_time=DRIVES[drive], stiffness=stiffness, substeps=1)
    dt = 1.0 / 240.0
    motion = motion.resample(240.0)
    simulator = Simulator(scene, body=body, settings=settings, fps=240)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    targets = simulator.world.motion_coordinates([motion])
    own = person_drive(simulator, settings, targets[0])
    ball = simulator.world.objects[0].dof
    contacts = 0
    violation = []
    for t in range(1, len(motion)):
        qpos, qvel = np.array(stepper.qpos()), np.array(stepper.qvel())
        own.begin_frame(targets[t], dt, qpos, qvel)
        simulator.step(motion[t])
        if t % 5:
            own.end_substep(stepper.qvel())
            continue
        trace = stepper.trace()
        M = reference.inertia_matrix(model, qpos)
        stiff = reference.stiff_diagonal(model, M, own)
        v_free = qvel.copy()
        v_free[own.dofs] = own.free_velocity(
            0, dt, qpos, qvel, M[own.dofs, own.dofs], stiff[own.dofs]
        )
        v_free[ball + 2] -= 9.81 * dt
        np.testing.assert_allclose(trace["v_free"], v_free, atol=VELOCITY)
        points = with_ranges(simulator, trace)
        contacts += len(trace["contacts"]["dist"])
        scale = np.ones(model.nv)
        scale[own.dofs] = own.scale(dt)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])
        M_hat = np.sqrt(np.outer(scale, scale)) * (M + np.diag(held))
        problem = reference.contact_problem(model, qpos, v_free, M_hat, dt, points)
        # The same impulses have the same effect on both; and they obey the law of contact.
        np.testing.assert_allclose(trace["v"], problem.velocity(problem.found), atol=VELOCITY)
        violation.append(residuals(problem))
        own.end_substep(stepper.qvel())
    assert contacts > 200
    # In micrometres a substep, the solver's tolerance being one: normals always hold. The solver
    # once gives up friction on dozens of points of a limp body pressed flat.
    normal, friction = np.array(violation).T * dt / settings.tolerance
    assert normal.max() <= 5.0
    assert np.quantile(friction, 0.8) <= 1.0
    if stiffness > 0.0:
        assert friction.max() <= 5.0


def with_ranges(simulator, trace):
    """The contacts of a substep, and the rows of the person's joints as others of them."""
    person = simulator.world.people[0]
    axes = JointRanges.of(person.body).axes[person.balls]
    return joined(trace["contacts"], trace["ranges"], axes, simulator.world.model.nv)


def residuals(problem):
    """Largest residual of the normals and of friction [m/s] in the core's solution."""
    found = problem.found.reshape(-1, 3)
    if len(found) == 0:
        return 0.0, 0.0
    return contact_residual(problem.A, problem.b, problem.friction, found).max(axis=0)


@pytest.mark.parametrize("drive", DRIVES)
def test_contact_of_a_person_solved_independently(body, drive):
    """A firm body walks into a wall: both solve the same problem to rounding, each from zero.

    Its parts have several contact points each; the velocities are unique all the same.
    """
    motion = along_x(1.5, 16, start=-0.2).grounded(body, 0.0005).resample(240.0)
    scene = Scene()
    scene.add_static("wall", Box((0.01, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=0.3)
    settings = as_it_is(
        drive_time=DRIVES[drive],
        stiffness=10.0,
        tolerance=1e-13,
        max_sweeps=400,
        substeps=1,
    )
    dt = 1.0 / 240.0
    simulator = Simulator(scene, body=body, settings=settings, fps=240)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    targets = simulator.world.motion_coordinates([motion])
    own = person_drive(simulator, settings, targets[0])
    compared = most = 0
    for t in range(1, len(motion)):
        qpos = np.array(stepper.qpos())
        simulator.step(motion[t])
        trace = stepper.trace()
        n = len(trace["contacts"]["dist"])
        if t % 2 or not 0 < n <= 40:
            continue
        M = reference.inertia_matrix(model, qpos)
        stiff = reference.stiff_diagonal(model, M, own)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])
        M = own.scale(dt) * (M + np.diag(held))
        problem = reference.contact_problem(model, qpos, trace["v_free"], M, dt, trace["contacts"])
        p = problem.solve(tolerance=1e-12, sweeps=2000)
        assert problem.violation(p) <= 1e-12
        np.testing.assert_allclose(trace["v"], problem.velocity(p), atol=VELOCITY)
        compared += 1
        most = max(most, n)
    assert compared >= 5
    assert most >= 10


def test_contact_solved_independently():
    """800 substeps in which both solve to rounding: balls that roll, meet each other and a wall.

    Every pair has one point of contact, so the velocities are unique.
    """
    scene = Scene()
    scene.add_static("floor", Plane(), friction=0.6)
    scene.add_static("wall", Box((0.1, 4.0, 2.0)), position=(1.5, 0.0, 0.0))
    scene.add_object(
        "cue",
        Sphere(0.1),
        mass=2.0,
        friction=0.4,
        restitution=0.3,
        position=(0, 0, 0.12),
        velocity=(3, 0.2, 0),
        angular_velocity=(9.0, 5.0, 1.0),
    )
    for i in range(4):
        scene.add_object(
            f"ball{i}", Sphere(0.1), mass=0.5, position=(0.7 + 0.22 * (i // 2), 0.21 * (i % 2), 0.1)
        )
    simulator = Simulator(
        scene, body=[], settings=as_it_is(tolerance=1e-12, max_sweeps=5000), fps=240
    )
    simulator.reset([])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    most = 0
    for _ in range(800):
        qpos = np.array(stepper.qpos())
        simulator.step([])
        trace = stepper.trace()
        points = trace["contacts"]
        most = max(most, len(points["dist"]))
        M = reference.inertia_matrix(model, qpos)
        problem = reference.contact_problem(model, qpos, trace["v_free"], M, trace["h"], points)
        np.testing.assert_allclose(trace["v"], problem.velocity(problem.solve()), atol=VELOCITY)
    assert most >= 6


@pytest.mark.parametrize(
    ("drive", "strength"),
    [("time constant", "human"), ("time constant", "weak"), ("algorithm 1", None)],
)
def test_firmness_and_strength_by_joint_are_equal(body, drive, strength):
    """Every joint has its own firmness and, with a time constant, a limit that a wall exceeds: the
    free velocity, the joints that yield in each round and how far, the effect of contacts, and
    the drive's torques, computed twice in every substep."""
    dt = 1.0 / 240.0
    # From some other starts an arm without strength is thrown, and substeps are made in pieces.
    motion = along_x(1.5, 10, start=0.2005).resample(240.0)
    scene = Scene()
    scene.add_static("wall", Box((0.1, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=0.3)
    settings = as_it_is(
        contact="parts",
        drive_time=DRIVES[drive],
        stiffness={"legs": 0.0, "arms": 3.0, "hands": 1.0, "spine2": 0.3},
        strength=WEAK if strength == "weak" else strength,
        substeps=1,
        joint_limits=strength == "human",
    )
    simulator = Simulator(scene, body=body, settings=settings, fps=240)
    simulator.reset(motion[0])
    stepper, model = simulator.world.stepper, simulator.world.model
    stepper.keep_trace(True)
    targets = simulator.world.motion_coordinates([motion])
    own = person_drive(simulator, settings, targets[0])
    if settings.strength is not None:
        force, torque = limits_of(settings.strength, body)
        own.limits = np.concatenate([[force], torque[reference.depth_first()]])
    touched = 0
    rounds = []
    for t in range(1, len(motion)):
        qpos, qvel = np.array(stepper.qpos()), np.array(stepper.qvel())
        own.begin_frame(targets[t], dt, qpos, qvel)
        frame = simulator.step(motion[t])
        trace = stepper.trace()
        if trace["h"] == 0.0:  # no contact was near yet
            own.end_substep(np.array(stepper.qvel()))
            continue
        M = reference.inertia_matrix(model, qpos)
        stiff = reference.stiff_diagonal(model, M, own)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])[own.dofs]
        M, stiff = M[own.dofs, own.dofs], stiff[own.dofs]
        v_free = own.free_velocity(0, dt, qpos, qvel, M, stiff)
        np.testing.assert_allclose(trace["v_free"][own.dofs], v_free, atol=VELOCITY)
        for v in trace["overcome"][1:]:  # later rounds exceed the limits with joints held
            assert own.overcome(v[own.dofs], v_free, dt, M, stiff)
        stiff = held
        v = trace["v"][own.dofs]
        assert not own.overcome(v, v_free, dt, M, stiff)
        problem = reference.contact_problem(
            model,
            qpos,
            trace["v_free"],
            own.heavier(dt, M, stiff),
            dt,
            with_ranges(simulator, trace),
        )
        np.testing.assert_allclose(trace["v"], problem.velocity(problem.found), atol=VELOCITY)
        new = np.array(stepper.qvel())
        impulse = own.exerted(new[own.dofs], v_free, dt, M, stiff)
        expected = np.zeros((55, 3))
        expected[reference.depth_first()] = impulse[3:].reshape(-1, 3) / dt
        np.testing.assert_allclose(frame.torque, expected, atol=TORQUE)
        touched += len(frame.contacts.part) > 0
        rounds.append(own.yielding.rounds)
        own.end_substep(new)
    assert touched > 20
    assert (max(rounds) > 0) == (settings.strength is not None)
