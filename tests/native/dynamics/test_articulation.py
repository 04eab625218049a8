"""Undriven trees alone in the core: against MuJoCo, without contact."""

import mujoco
import numpy as np
import pytest

from halfphysics import _native
from halfphysics.simulation.compiled_model import joint_arrays, model_arrays

GRAVITY = np.array([0.0, 0.0, -9.81])
#: Rounding of torques of some hundred N m.
EXACT = 1e-11


def stepper_of(model, gravity=GRAVITY):
    """A stepper that moves an MjModel's trees, without shapes."""
    stepper = _native.Stepper()
    stepper.set_model(**model_arrays(model))
    stepper.set_joint_forces(**joint_arrays(model))
    stepper.set_pairings(*(np.zeros((1, 1)) for _ in range(3)))
    stepper.set_drive(time_constant=0.02, recovery_rate=8.0, recover_root=False, root_speed=1.0)
    stepper.set_contact(
        clearance=1e-3,
        clearance_range=0.05,
        depenetration_speed=0.5,
        tolerance=1e-6,
        max_sweeps=50,
        gravity=gravity,
    )
    stepper.finish([])
    return stepper


def run(model, qpos, qvel, h, steps):
    """Coordinates (steps + 1, nq) and the last velocities."""
    stepper = stepper_of(model)
    stepper.reset(np.array(qpos, float), np.array(qvel, float))
    track = [stepper.qpos()]
    for _ in range(steps):
        stepper.frame(np.zeros(0), h, 1, False)
        track.append(stepper.qpos())
    return np.array(track), stepper.qvel()


def compiled(body, options=""):
    xml = f"<mujoco><option {options}/><worldbody>{body}</worldbody></mujoco>"
    return mujoco.MjModel.from_xml_string(xml)


PENDULUM = """
<body name="a" pos="0.1 0.2 1"><joint name="a" type="hinge" axis="0 1 0" pos="0 0 .05" {a}/>
  <geom type="capsule" fromto="0 0 0 .3 0 -.2" size=".03" contype="0" conaffinity="0"/>
  <body name="b" pos=".3 0 -.2" euler="10 20 30">
    <joint name="b" type="hinge" axis="1 1 0.2" {b}/>
    <geom type="box" pos=".1 0 -.1" size=".1 .02 .05" contype="0" conaffinity="0"/>
  </body>
</body>"""

ROBOT = """
<body name="base" pos="0 0 1"><freejoint/>
  <geom type="box" size=".2 .1 .05"/>
  <body name="one" pos=".2 0 0"><joint type="ball" pos="0 0 .01"/><joint type="slide" axis="0 1 1"/>
    <geom type="capsule" fromto="0 0 0 .3 0 .1" size=".04"/>
    <body name="two" pos=".3 0 .1" euler="0 40 0">
      <joint type="hinge" axis="0 0 1" armature=".1"/><joint type="hinge" axis="0 1 0"/>
      <geom type="box" pos=".1 0 0" size=".1 .03 .02"/></body></body>
  <body name="fixed" pos="-.2 0 0" euler="0 30 10"><geom size=".06"/>
    <body name="three" pos="-.1 0 0"><joint type="slide" axis="1 0 0" ref=".02"/>
      <geom size=".05"/></body></body>
</body>"""


def test_inertia_and_bias_are_those_of_mujoco():
    rng = np.random.default_rng(3)
    for body in (PENDULUM.format(a="", b=""), ROBOT):
        model = compiled(body)
        stepper, data = stepper_of(model), mujoco.MjData(model)
        for _ in range(5):
            mujoco.mj_resetData(model, data)
            mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
            data.qvel[:] = 3.0 * rng.normal(size=model.nv)
            mujoco.mj_forward(model, data)
            dense = np.zeros((model.nv, model.nv))
            mujoco.mj_fullM(model, data, dense)
            np.testing.assert_allclose(stepper.inertia_matrix(data.qpos), dense, atol=EXACT)
            bias = stepper.bias_forces(data.qpos, data.qvel)
            np.testing.assert_allclose(bias, data.qfrc_bias, atol=EXACT)


def test_damped_steps_are_those_of_mujoco():
    """MuJoCo's Euler steps also take damping at the end of the step: the same numbers."""
    body = PENDULUM.format(a='damping="0.3"', b='damping="0.05" armature="0.01"')
    model = compiled(body, 'timestep="0.002"')
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = [0.3, -0.8], [1.0, 4.0]
    track, _ = run(model, data.qpos, data.qvel, 0.002, 500)
    for q in track:
        np.testing.assert_allclose(data.qpos, q, atol=1e-9)
        mujoco.mj_step(model, data)
    assert np.ptp(track, axis=0).min() > 0.5


def errors_of(model, qpos, qvel, seconds, steps):
    """Largest errors at the end for several step counts, against RK4 with a fine step."""
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    for _ in range(round(seconds / 1e-4)):
        mujoco.mj_step(model, data)
    return np.array(
        [np.abs(run(model, qpos, qvel, seconds / n, n)[0][-1] - data.qpos).max() for n in steps]
    )


@pytest.mark.parametrize(
    ("a", "b"), [("", ""), ('stiffness="3" springref="20"', 'stiffness="1" damping="0.05"')]
)
def test_converges_to_the_exact_motion(a, b):
    """First order: half the step gives half the error."""
    model = compiled(PENDULUM.format(a=a, b=b))
    found = errors_of(model, [0.3, -0.8], [0.5, 1.0], 1.0, (1000, 2000, 4000))
    assert found[0] < 0.02
    assert 1.8 < found[0] / found[1] < 2.2
    assert 1.8 < found[1] / found[2] < 2.2


def test_spring_with_mass_is_the_closed_form():
    """A mass of 2 kg on 50 N/m with 4 N s/m: x = e^(-t) (cos w t + sin w t / w), w = sqrt(24)."""
    model = compiled(
        '<body><joint type="slide" axis="1 0 0" stiffness="50" damping="4" springref="0.3"/>'
        '<geom size="0.1" mass="2"/></body>'
    )
    w = np.sqrt(24.0)
    track, _ = run(model, [1.3], [0.0], 1e-4, 10000)
    t = 1e-4 * np.arange(len(track))
    exact = 0.3 + np.exp(-t) * (np.cos(w * t) + np.sin(w * t) / w)
    np.testing.assert_allclose(track[:, 0], exact, atol=1e-3)


def test_stiff_springs_stay_bounded():
    """Springs act with the velocity at the end of the step: stable at any step length."""
    model = compiled(
        '<body><joint type="slide" axis="1 0 0" stiffness="1e7" springref="0"/>'
        '<geom size="0.1" mass="1"/></body>'
    )
    track, _ = run(model, [0.1], [0.0], 0.01, 200)
    assert np.abs(track).max() <= 0.1
    assert np.abs(track[-1]) < 1e-3


def test_links_follow_their_joints():
    """Body frames follow from the coordinates, for all joint types."""
    model = compiled(ROBOT)
    rng, data = np.random.default_rng(5), mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    mujoco.mj_kinematics(model, data)
    position, _ = stepper_of(model).body_frames(data.qpos)
    np.testing.assert_allclose(position, data.xpos, atol=1e-12)


def test_limits_are_reached_and_never_passed():
    """Doors with closers and a drawer on a slope stop at their limits and stay there."""
    model = compiled(
        '<body><joint type="hinge" axis="0 0 1" range="-20 90" damping=".2"/>'
        '<geom type="box" pos=".4 0 0" size=".4 .02 1" mass="20"/>'
        '<body pos="0 0 .5" euler="0 30 0"><joint type="slide" axis="1 0 0" range="0 .3"/>'
        '<geom type="box" size=".2 .2 .1" mass="3"/></body></body>'
    )
    qpos, qvel = [0.0, 0.1], [2.5, 0.0]
    track, qvel = run(model, qpos, qvel, 1 / 480, 1000)
    low, high = model.jnt_range.T
    assert (track >= low).all()
    assert (track <= high).all()
    np.testing.assert_allclose(track[-1], high, atol=1e-6)
    np.testing.assert_allclose(qvel, 0.0, atol=1e-9)


def test_an_end_takes_the_momentum_and_nothing_more():
    """A chain stops at one joint's limit: the remaining velocity is the projection by exact M."""
    model = compiled(PENDULUM.format(a='range="-180 20"', b=""))
    h, start = 1e-4, np.array([np.deg2rad(20.0) - 1e-9, -0.8])
    stepper = stepper_of(model, gravity=np.zeros(3))
    stepper.reset(start, np.array([1.0, 0.0]))
    stepper.keep_trace(True)
    stepper.frame(np.zeros(0), h, 1, False)
    trace = stepper.trace()
    M = stepper.inertia_matrix(start)
    v, free = trace["v"], trace["v_free"]
    assert abs(v[0]) < 1e-9
    # The impulse acts on the first joint alone.
    np.testing.assert_allclose((M @ (v - free))[1], 0.0, atol=1e-12)
    assert (M @ (v - free))[0] < -0.1


def test_the_same_bits_twice_and_after_restoring():
    model = compiled(PENDULUM.format(a='range="-30 20"', b='damping="0.1"'))
    stepper = stepper_of(model)

    def go(steps):
        out = []
        for _ in range(steps):
            stepper.frame(np.zeros(0), 1 / 60, 8, False)
            out.append(stepper.qpos())
        return np.array(out)

    stepper.reset(np.array([0.1, 0.2]), np.zeros(2))
    go(20)
    state = stepper.save()
    first = go(40)
    stepper.load(state)
    assert (go(40) == first).all()
