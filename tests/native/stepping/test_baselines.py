"""Internal forces, joint damping and PD torques: against the plain numpy reference, MuJoCo
and mechanics."""

from __future__ import annotations

from copy import copy

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.baselines import Ablation, Torque, from_options, options_of
from halfphysics.baselines import reference as reference_ablations
from halfphysics.errors import InputError
from halfphysics.reference import step as reference
from halfphysics.simulation.simulator import Simulator
from support.people import along_x, t_pose, violent

#: The rest is M's conditioning (fingers of grams on 60 kg), as in reference/test_step.py.
VELOCITY = 1e-9
H = 1.0 / 240.0
LIMP = {"drive_time": None, "stiffness": 0.0}
ABLATIONS = {
    "internal forces, limp": {"internal_forces": True, **LIMP},
    "internal forces, algorithm 1": {"internal_forces": True, "drive_time": None},
    "internal forces, time constant": {"internal_forces": True},
    "damping, limp": {"joint_damping": 0.3, **LIMP},
    "damping, time constant": {"joint_damping": 0.3},
    "both, algorithm 1": {"internal_forces": True, "joint_damping": 0.1, "drive_time": None},
    "torque": {"mode": "torque"},
    "torque, all": {"mode": "torque", "internal_forces": True, "joint_damping": 0.2},
}


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def swinging(frames=20, fps=30.0, seed=5, speed=0.0):
    """Arms, legs and trunk swing at up to 8 rad/s while the root moves along x at `speed`."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None] / fps
    motion = t_pose(
        np.concatenate([speed * t + 0.1 * np.sin(3 * t), 0.2 * t, 0.05 * np.cos(9 * t)], axis=1),
        fps,
    )
    rotations = motion.rotations.copy()
    for joint in (1, 2, 3, 4, 5, 9, 15, 16, 17, 18, 19, 20, 21):
        way = rng.normal(size=3)
        phase = rng.uniform(0, 6)
        rotations[:, joint] = 0.8 * np.sin(8.0 * t + phase) * way / np.linalg.norm(way)
    return motion.with_frames(motion.translation, rotations)


def started(body, settings, motion, scene=None):
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    simulator.reset(motion[0])
    simulator.world.stepper.keep_trace(True)
    return simulator


def reference_drive(simulator, start):
    settings = simulator.settings
    model, person = simulator.world.model, simulator.world.people[0]
    dof = int(model.jnt_dofadr[model.body_jntadr[person.root]])
    kind = reference.ReferenceDrive
    if settings.drive.torque_frequency:
        kind = reference_ablations.TorqueDrive
    return kind(settings, person.qpos, dof, start)


def v_star(own, model, qpos, qvel, h):
    """v* (n,) of the person, and M (nv, nv) and diag(lambda I) (nv,)."""
    M = reference.inertia_matrix(model, qpos)
    stiff = reference.stiff_diagonal(model, M, own)
    rows, mine = M[own.dofs, own.dofs], stiff[own.dofs]
    v = own.free_velocity(0, h, qpos, qvel, rows, mine)
    c = np.zeros_like(v)
    if own.settings.drive.internal_forces:
        c = reference_ablations.bias(model, qpos, qvel)[own.dofs]
    if own.settings.drive.internal_forces or own.settings.drive.joint_damping:
        v = reference_ablations.with_own_forces(own, h, v, rows, mine, c)
    return v, M, stiff, c


@pytest.mark.slow
@pytest.mark.parametrize("name", ABLATIONS)
def test_free_velocities_are_equal(body, name):
    """Some substeps of a fast motion computed twice, without contact."""
    motion = swinging().resample(240.0)[:38]
    settings = from_options({"substeps": 1, **ABLATIONS[name]})
    simulator = started(body, settings, motion)
    stepper, model = simulator.world.stepper, simulator.world.model
    targets = simulator.world.motion_coordinates([motion])
    own = reference_drive(simulator, targets[0])
    for t in range(1, len(motion)):
        qpos, qvel = np.array(stepper.qpos()), np.array(stepper.qvel())
        own.begin_frame(targets[t], H, qpos, qvel)
        simulator.step(motion[t])
        if t % 12 == 1:
            v, *_ = v_star(own, model, qpos, qvel, H)
            np.testing.assert_allclose(stepper.trace()["v"][own.dofs], v, atol=1e-11)
            moved = stepper.integrate(qpos, v, H)
            np.testing.assert_allclose(stepper.qpos(), moved, atol=1e-12)
        own.end_substep(np.array(stepper.qvel()))


@pytest.mark.parametrize("name", ABLATIONS)
def test_velocities_with_contact_are_equal(body, name):
    """A wall and a ball in the way: free velocities, velocities after contact, and the drive's
    torques, computed twice."""
    motion = along_x(1.5, 10, start=0.2).resample(240.0)
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.01, 6.0, 6.0)), position=(0.6, 0.0, 0.0), friction=0.3)
    scene.add_object(
        "ball", hp.Sphere(0.1), mass=0.5, position=(0.45, 0.2, 1.0), velocity=(-1, 0, 0)
    )
    settings = from_options({"substeps": 1, **ABLATIONS[name]})
    simulator = started(body, settings, motion, scene)
    stepper, model = simulator.world.stepper, simulator.world.model
    targets = simulator.world.motion_coordinates([motion])
    own = reference_drive(simulator, targets[0])
    ball = simulator.world.objects[0].dof
    contacts = 0
    for t in range(1, len(motion)):
        qpos, qvel = np.array(stepper.qpos()), np.array(stepper.qvel())
        own.begin_frame(targets[t], H, qpos, qvel)
        frame = simulator.step(motion[t])
        new = np.array(stepper.qvel())
        if t % 14 or frame.diagnostics["shortened"]:  # a split step has several M
            own.end_substep(new)
            continue
        trace = stepper.trace()
        v_free = qvel.copy()
        v_free[own.dofs], M, stiff, c = v_star(own, model, qpos, qvel, H)
        v_free[ball + 2] -= 9.81 * H
        np.testing.assert_allclose(trace["v_free"], v_free, atol=VELOCITY)
        held = reference.held_diagonal(model, stiff, own, trace["touched"])
        M_hat = M.copy()
        mine = (own.dofs, own.dofs)
        M_hat[mine] = reference_ablations.heavier(own, H, M[mine], held[own.dofs])
        problem = reference.contact_problem(model, qpos, v_free, M_hat, H, trace["contacts"])
        np.testing.assert_allclose(trace["v"], problem.velocity(problem.found), atol=VELOCITY)
        contacts += len(trace["contacts"]["dist"])
        # Newton's second law: contacts and the person's own forces explain all changes of velocity.
        e = new[own.dofs] - own.v_ref - own.deviation
        by_contacts = (M_hat @ (new - v_free))[own.dofs]
        damped = H * reference_ablations.damping(own) * new[own.dofs]
        impulse = M[mine] @ e - by_contacts + H * c + damped
        expected = np.zeros((55, 3))
        expected[reference.depth_first()] = impulse[3:].reshape(-1, 3) / H
        # Up to 1e4 N m times the error by conditioning.
        np.testing.assert_allclose(frame.torque, expected, atol=1e-4)
        own.end_substep(new)
    assert contacts > 10


def oracle(simulator, dof_damping=0.0, kp=0.0, target=None, *, internal=True):
    """MuJoCo's own step of the person from the last substep's start, with implicit damping."""
    world = simulator.world
    trace = world.stepper.trace()
    model = copy(world.model)
    model.opt.gravity[:] = 0.0
    model.opt.timestep = trace["h"]
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.dof_damping[6:] = dof_damping
    model.jnt_stiffness[1:] = kp
    if target is not None:
        model.qpos_spring[:] = target
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = trace["qpos"], trace["qvel"]
    if not internal:
        mujoco.mj_forward(model, data)
        data.qfrc_applied[:] = data.qfrc_bias
    mujoco.mj_step(model, data)
    return data.qvel.copy()


@pytest.mark.parametrize("damping", [0.0, 0.4])
def test_internal_forces_and_damping_are_those_of_mujoco(body, damping):
    motion = swinging().resample(240.0)
    settings = Ablation(substeps=1, internal_forces=True, joint_damping=damping, **LIMP)
    simulator = started(body, settings, motion)
    model = simulator.world.model
    largest = 0.0
    for t in range(1, 60):
        simulator.step(motion[t])
        trace = simulator.world.stepper.trace()
        np.testing.assert_allclose(trace["v"], oracle(simulator, damping), atol=VELOCITY)
        largest = max(largest, np.abs(trace["v"] - trace["qvel"]).max())
    assert largest > 0.1  # [rad/s] in one substep
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = trace["qpos"], trace["qvel"]
    model.opt.gravity[:] = 0.0
    mujoco.mj_forward(model, data)
    c = reference_ablations.bias(model, trace["qpos"], trace["qvel"])
    np.testing.assert_allclose(c, data.qfrc_bias, atol=1e-11 * np.abs(c).max())


def test_torques_are_those_of_mujoco(body):
    """Springs and dampers at the end of the step equal MuJoCo's with h kp added to the damping."""
    motion = swinging().resample(240.0)
    settings = Torque(substeps=1, frequency=60.0, damping=0.7)
    simulator = started(body, settings, motion)
    targets = simulator.world.motion_coordinates([motion])
    model = simulator.world.model
    for t in range(1, 40):
        simulator.step(motion[t])
        trace = simulator.world.stepper.trace()
        inertia = np.diag(reference.inertia_matrix(model, trace["qpos"]))[6:].reshape(-1, 3).mean(1)
        kp = inertia * 60.0**2
        kd = 2.0 * 0.7 * 60.0 * inertia
        expected = oracle(simulator, np.repeat(kd + H * kp, 3), kp, targets[t], internal=False)
        np.testing.assert_allclose(trace["v"], expected, atol=VELOCITY)


def momentum(simulator, qvel):
    """Momentum, angular momentum about the centre of mass, and kinetic energy of the person."""
    model = simulator.world.model
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = simulator.world.stepper.qpos(), qvel
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    mass = model.body_subtreemass[1]
    M = reference.inertia_matrix(model, data.qpos)
    return mass * data.subtree_linvel[1], data.subtree_angmom[1].copy(), 0.5 * qvel @ M @ qvel


def flight(body, substeps, **options):
    """One limp frame of 0.1 s: its initial and its final values."""
    motion = swinging(fps=10.0)
    simulator = started(body, from_options({"substeps": substeps, **options, **LIMP}), motion)
    targets = simulator.world.motion_coordinates([motion])
    own = reference_drive(simulator, targets[0])
    qvel = np.array(simulator.world.stepper.qvel())
    own.begin_frame(targets[1], 0.1, np.array(simulator.world.stepper.qpos()), qvel)
    before = momentum(simulator, qvel)
    simulator.step(motion[1])
    return before, momentum(simulator, np.array(simulator.world.stepper.qvel()))


def test_a_limp_body_in_flight_keeps_momentum_and_energy_to_first_order(body):
    def drift(substeps, **options):
        before, after = flight(body, substeps, **options)
        return np.array([np.linalg.norm(b - a) for a, b in zip(before, after, strict=True)]), before

    coarse, (p, spin, energy) = drift(200, internal_forces=True)
    fine, _ = drift(400, internal_forces=True)
    assert min(np.linalg.norm(p), np.linalg.norm(spin), energy) > 1.0
    assert np.all(coarse < 0.02 * np.array([np.linalg.norm(p), np.linalg.norm(spin), energy]))
    np.testing.assert_allclose(coarse / fine, 2.0, rtol=0.1)
    # Damping acts between the parts: it takes energy, and no momentum.
    damped, _ = drift(400, internal_forces=True, joint_damping=0.5)
    assert damped[2] > 0.1 * energy
    np.testing.assert_allclose(damped[:2], 0.0, atol=1.5 * coarse[:2].max())
    # The paper's own free motion, without internal forces, keeps velocities instead.
    plain, _ = drift(400)
    assert np.all(plain[:2] > 20.0 * fine[:2])


@pytest.mark.parametrize("drive", [None, 0.02])
def test_damping_slows_joints(body, drive):
    """More damping slows joints more; limp joints of Algorithm 1 lose energy by it for good."""
    motion = swinging(fps=10.0)
    speeds, energies = [], []
    for damping in (0.0, 0.1, 1.0, 10.0):
        settings = Ablation(substeps=100, stiffness=0.0, drive_time=drive, joint_damping=damping)
        simulator = started(body, settings, motion)
        simulator.step(motion[1])
        qvel = np.array(simulator.world.stepper.qvel())
        speeds.append(np.linalg.norm(qvel[6:]))
        energies.append(momentum(simulator, qvel)[2])
    assert np.all(np.diff(speeds) < -0.03 * speeds[0])
    if drive is None:
        assert np.all(np.diff(energies) < -0.03 * energies[0])


@pytest.mark.parametrize("name", ABLATIONS)
def test_the_same_again_and_from_a_state_in_the_middle(body, name):
    motion = swinging(12, speed=1.5)
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.01, 6.0, 6.0)), position=(1.0, 0.0, 0.0))
    settings = from_options({"contact": "parts", **ABLATIONS[name]})
    poses = []
    for _ in range(2):
        simulator = started(body, settings, motion, scene)
        frames = [simulator.step(motion[t]) for t in range(1, 6)]
        state = simulator.get_state()
        frames += [simulator.step(motion[t]) for t in range(6, 12)]
        poses.append(np.array([f._qpos for f in frames]))
    np.testing.assert_array_equal(poses[0], poses[1])
    other = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    other.set_state(state)
    again = np.array([other.step(motion[t])._qpos for t in range(6, 12)])
    np.testing.assert_array_equal(again, poses[0][5:])
    whole = hp.simulate(motion, scene, body=body, settings=settings)
    np.testing.assert_array_equal(
        whole.people[0].motion.translation[-1], frames[-1].pose.translation
    )
    assert len(whole.contacts) > 0


def test_what_each_costs_on_a_dance(body):
    """As in the paper's Tables 3 and 4 all baselines have an error, and half-physics has none."""
    motion = swinging(90)

    def errors(**options):
        settings = from_options({**options_of(hp.Settings.paper()), **options})
        got = hp.simulate(motion, body=body, settings=settings).people[0].motion
        return hp.metrics.mpjpe_global(got, motion, body), hp.metrics.mpjpe(got, motion, body)

    assert max(errors()) < 1e-6
    inner = errors(internal_forces=True)
    both = errors(internal_forces=True, joint_damping=0.1)
    torque = errors(mode="torque")
    assert inner[0] > max(10.0, 3.0 * inner[1])  # the root's position is not corrected
    assert both[1] > inner[1]
    assert torque[0] > 10.0
    assert torque[1] > 5.0
    # Tuned: neither softer nor harder gains follow better.
    for frequency in (30.0, 300.0):
        assert errors(mode="torque", torque_frequency=frequency)[0] > torque[0]


@pytest.mark.parametrize("name", ABLATIONS)
def test_violent_motions_end(body, name):
    motion = violent(frames=30)
    result = hp.simulate(motion, body=body, settings=from_options(ABLATIONS[name]))
    moved = np.diff(result.people[0].motion.translation, axis=0)
    assert np.abs(moved).max() < 1.5  # [m] in a frame; finite


@pytest.mark.parametrize("name", ABLATIONS)
def test_contact_is_as_ever(body, name):
    """Two people: one walks into a wall and stays clear of it, one kicks a ball away."""
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.01, 6.0, 6.0)), position=(0.8, 0.0, 0.0))
    scene.add_object("ball", hp.Sphere(0.1), mass=0.5, position=(0.3, 3.0, 0.9))
    walks = along_x(1.2, 30, start=0.0)
    other = walks.with_frames(walks.translation + np.array([0.0, 3.0, 0.0]), walks.rotations)
    settings = from_options({"contact": "parts", **ABLATIONS[name]})
    result = hp.simulate([walks, other], scene, body=body, settings=settings)
    assert result.clearance.min() > 0.0
    assert result.people[0].motion.translation[-1, 0] < 0.8
    assert np.abs(result.people[0].torque).max() > 1.0
    assert np.linalg.norm(result.objects["ball"].position[12] - [0.3, 3.0, 0.9]) > 0.05
    assert result.lost_time.max() < 1e-3


def test_in_a_world_of_mujocos(body):
    spec = mujoco.MjSpec()
    human = hp.attach(spec, body)
    model = spec.compile()
    model.opt.timestep = H
    motion = swinging(6)
    ends = []
    for name in ("both, algorithm 1", "torque"):
        data = mujoco.MjData(model)
        settings = from_options({"substeps": 8, **ABLATIONS[name]})
        control = human.bind(model, data, settings=settings)
        simulator = Simulator(body=body, settings=settings, fps=30.0)
        simulator.reset(motion[0])
        control.reset(motion[0])
        for t in range(1, 6):
            control.step(motion[t], dt=1.0 / 30.0)
            frame = simulator.step(motion[t])
        ends.append(np.array(control._stepper.qpos()))
        np.testing.assert_allclose(ends[-1], frame._qpos, atol=1e-9)
    assert np.abs(ends[0] - ends[1]).max() > 1e-3


def test_nobody_bears_what_is_tied_to_them(body):
    scene = hp.Scene()
    scene.add_object("stick", hp.Box((0.02, 0.02, 0.5)), mass=1.0, position=(2.0, 0.0, 1.0))
    for name in ("torque", "damping, limp", "internal forces, time constant"):
        simulator = Simulator(scene, body=body, settings=from_options(ABLATIONS[name]))
        simulator.reset(swinging()[0])
        with pytest.raises(InputError, match="does not bear"):
            simulator.attach("stick")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"internal_forces": True, "strength": "human"}, "strength limits half-physics"),
        ({"joint_damping": 0.1, "strength": "human"}, "strength limits half-physics"),
        ({"mode": "torque", "strength": "human"}, "strength limits half-physics"),
        ({"mode": "torque", "torque_frequency": 0.0}, "number > 0"),
        ({"mode": "torque", "torque_damping": -1.0}, "number >= 0"),
        ({"joint_damping": -0.1}, "number >= 0"),
        ({"internal_forces": 1}, "True or False"),
    ],
)
def test_what_makes_no_sense_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        from_options(options)
