"""A person in a user's own MuJoCo world: `hp.attach`."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics import rotations as rot
from halfphysics.errors import InputError

#: A robot arm of three hinges on a stand; its hand goes along y at x = 0.45 (see `reach`).
ARM = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="base" pos="{x} {y} 1.25">
      <geom name="stand" type="cylinder" size="0.05 0.05" mass="5"/>
      <body name="upper">
        <joint name="yaw" axis="0 0 1" damping="2"/>
        <geom name="upper" type="capsule" fromto="0 0 0 0 0.35 0" size="0.04" mass="3"/>
        <body name="fore" pos="0 0.35 0">
          <joint name="elbow" axis="0 0 1" damping="1"/>
          <geom name="fore" type="capsule" fromto="0 0.1 0 0 0.35 0" size="0.035" mass="2"/>
        </body>
      </body>
    </body>
    {more}
  </worldbody>
  <actuator>
    <position name="yaw" joint="yaw" kp="400" dampratio="1" forcerange="-{force} {force}"/>
    <position name="elbow" joint="elbow" kp="200" dampratio="1" forcerange="-{force} {force}"/>
  </actuator>
</mujoco>
"""


def spec_of(x: float = 0.9, y: float = 0.0, force: float = 200.0, more: str = "") -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(ARM.format(x=x, y=y, force=force, more=more))


def t_pose(x: float = 0.0, height: float = 0.95) -> hp.Pose:
    """Upright, arms out along x, the pelvis about `height` over the floor."""
    rotations = np.zeros((55, 3))
    rotations[0] = (np.pi / 2.0, 0.0, 0.0)
    joints = hp.Body.default().rest_joints
    return hp.Pose(np.array([x, 0.0, height]) - joints[0], rotations)


def sweep(model: mujoco.MjModel, data: mujoco.MjData, step, seconds: float, to: float) -> list:
    """Turn the arm about its yaw joint to `to` [rad], slowly; what `step` gives each time."""
    out = []
    count = round(seconds / model.opt.timestep)
    for i in range(count):
        data.ctrl[0] = to * min(1.0, 2.0 * (i + 1) / count)
        out.append(step())
    return out


def test_robot_moves_as_without_the_person_where_nothing_touches():
    alone = spec_of(x=3.0).compile()
    data = mujoco.MjData(alone)
    spec = spec_of(x=3.0)
    human = hp.attach(spec)
    model = spec.compile()
    ours = mujoco.MjData(model)
    control = human.bind(model, ours)
    pose = t_pose()
    control.reset(pose)
    path = sweep(
        alone, data, lambda: (mujoco.mj_step(alone, data), data.qpos.copy())[1], 1.0, 1.2
    )
    mine = sweep(model, ours, lambda: (control.step(pose), ours.qpos[:2].copy())[1], 1.0, 1.2)
    # Sums of masses in another order: rounding, over 500 steps.
    np.testing.assert_allclose(mine, path, rtol=0.0, atol=1e-12)
    assert ours.time == pytest.approx(1.0)


def test_motion_is_followed_exactly_where_nothing_touches():
    spec = spec_of(x=3.0)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    model.opt.timestep = 1.0 / 480.0
    control = human.bind(model, data)
    sequence = hp.scenarios.load("walk_into_wall")
    motion = sequence.motion[:20]
    control.reset(motion[0])
    for i in range(1, 20):
        control.step(motion[i], dt=1.0 / motion.fps)
        np.testing.assert_allclose(control.pose.translation, motion[i].translation, atol=1e-12)
        apart = rot.log(
            rot.multiply(
                rot.conjugate(rot.exp(control.pose.rotations)), rot.exp(motion[i].rotations)
            )
        )
        assert np.abs(apart).max() < 1e-12


@pytest.fixture(scope="module")
def pushed():
    """The arm sweeps into the person's right arm: limp, firm, and a robot too weak."""
    results = {}
    for name, stiffness, force in (("limp", 0.0, 200.0), ("firm", 10.0, 200.0), ("weak", 10.0, 2.0)):
        spec = spec_of(x=-0.55, y=-0.75, force=force)
        human = hp.attach(spec)
        model = spec.compile()
        data = mujoco.MjData(model)
        settings = (
            hp.Settings.paper(0.0) if stiffness == 0.0 else hp.Settings(stiffness=stiffness)
        )
        control = human.bind(model, data, settings=settings)
        pose = t_pose(height=1.25 - 0.43)
        control.reset(pose)
        touched, least = 0, np.inf
        for i in range(500):
            data.ctrl[0] = -0.9 * min(1.0, i / 250.0)
            control.step(pose)
            touched += len(control.contacts.part) > 0
            least = min(least, control.clearance)
        results[name] = (control, model, data, pose, touched, least)
    return results


def turned(control, pose) -> float:
    """Largest turn of a joint away from the pose [degrees]."""
    away = rot.multiply(
        rot.conjugate(rot.exp(pose.rotations)), rot.exp(control.pose.rotations)
    )
    return float(np.degrees(np.linalg.norm(rot.log(away), axis=-1).max()))


def test_arm_pushes_a_limp_person_aside(pushed):
    control, _, data, pose, touched, _ = pushed["limp"]
    assert touched > 50
    assert turned(control, pose) > 5.0


def test_firm_person_is_displaced_whole(pushed):
    control, _, data, pose, touched, _ = pushed["firm"]
    assert touched > 50
    assert turned(control, pose) < 2.0
    assert np.linalg.norm(control.pose.translation - pose.translation) > 0.02
