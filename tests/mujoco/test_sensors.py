"""What MuJoCo's sensors say of a person's push and weight."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.body import Body
from support.mujoco_worlds import HEIGHT, WRIST, t_pose

ARM = f"""
<mujoco>
  <option timestep="0.002" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="arm" pos="-1.1 -0.45 {HEIGHT + WRIST}">
      <joint name="yaw" axis="0 0 1" damping="2"/>
      <geom type="capsule" fromto="0 0 0 0 0.3 0" size="0.04" mass="2"/>
      <body name="hand" pos="0 0.35 0">
        <geom name="hand" type="capsule" fromto="0 0.05 0 0 0.35 0" size="0.035" mass="1"/>
        <site name="wrist"/>
        <site name="pad" type="box" pos="0 0.2 0" size="0.06 0.3 0.06"/>
        <site name="far" type="sphere" pos="0 0 0.3" size="0.02"/>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="yaw" kp="300" dampratio="1" forcerange="-60 60"/></actuator>
  <sensor>
    <touch name="pad" site="pad"/><touch name="far" site="far"/>
    <touch name="weak" site="pad" cutoff="0.5"/>
    <force name="force" site="wrist"/><accelerometer name="acceleration" site="wrist"/>
  </sensor>
</mujoco>
"""


@pytest.fixture(scope="module")
def pressed():
    """The moment in which the arm presses on a person: model, data, control, free acceleration."""
    spec = mujoco.MjSpec.from_string(ARM)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(stiffness=3.0))
    data.qpos[0] = data.ctrl[0] = -0.5 * np.pi
    control.reset(t_pose())
    data.ctrl[0] += 0.8
    for _ in range(400):
        control.step(t_pose())
    assert len(control.contact)
    return model, data, control


def test_touch_reads_the_force_of_the_contact(pressed):
    _, data, control = pressed
    normal = control.contact.force[:, 0].sum()
    assert normal > 5.0
    assert data.sensor("pad").data[0] == pytest.approx(normal, rel=1e-12)
    assert data.sensor("far").data[0] == 0.0
    assert data.sensor("weak").data[0] == 0.5


def test_external_force_of_a_body_is_the_persons(pressed):
    """`cfrc_ext`, which MuJoCo has about the tree's centre of mass."""
    model, data, control = pressed
    force = -control.contact.world_force.sum(axis=0)
    np.testing.assert_allclose(data.cfrc_ext[model.body("hand").id, 3:], force, rtol=1e-12)


def test_force_sensor_feels_the_person(pressed):
    """At rest, without gravity: the wrist bears what the person presses with."""
    _, data, control = pressed
    site = data.site("wrist").xmat.reshape(3, 3)
    push = site.T @ -control.contact.world_force.sum(axis=0)
    bears = data.sensor("force").data
    inertial = 1.0 * data.sensor("acceleration").data  # [kg] [m/s^2]
    # The hand's centre of mass is 0.2 m off the site: what turns adds little at rest.
    np.testing.assert_allclose(bears, inertial - push, atol=0.05 * np.linalg.norm(push) + 0.1)


def test_forces_end_with_the_contact(pressed):
    model, data, control = pressed
    data.ctrl[0] -= 0.8
    for _ in range(300):
        control.step(t_pose())
    assert not len(control.contact)
    assert data.sensor("pad").data[0] == 0.0
    assert not data.cfrc_ext[model.body("hand").id].any()
    assert not data.xfrc_applied.any()


def test_who_stands_on_a_scale_is_weighed():
    """A touch sensor and a spring under a person, and MuJoCo's floor under a box with a person."""
    spec = mujoco.MjSpec.from_string("""<mujoco><option timestep="0.004"/><worldbody>
      <geom name="floor" type="plane" size="5 5 0.1"/>
      <body name="scale" pos="0 0 0.15"><joint type="slide" axis="0 0 1" stiffness="5e4"
        damping="2e3"/><geom type="box" size="0.4 0.4 0.05" mass="5"/>
        <site name="top" type="box" size="0.5 0.5 0.2"/></body>
      <body name="box" pos="3 0 0.1"><freejoint/>
        <geom name="box" type="box" size="0.4 0.4 0.1" mass="10"/></body></worldbody>
      <sensor><touch name="top" site="top"/></sensor></mujoco>""")
    people = [hp.attach(spec, prefix=prefix) for prefix in ("a/", "b/")]
    model = spec.compile()
    data = mujoco.MjData(model)
    control = hp.bind(model, data, people)
    start, up = t_pose(), HEIGHT - 0.01 - Body.default().rest_joints[0][2]
    on = [
        hp.Pose(np.array([x, start.translation[1], up + z]), start.rotations)
        for x, z in ((start.translation[0], 0.201), (start.translation[0] + 3.0, 0.201))
    ]
    control.reset(on)
    for _ in range(45):
        control.step(on, dt=1.0 / 30.0)
    weight = 9.81 * sum(part.mass for part in Body.default().variant.parts)
    assert data.sensor("top").data[0] == pytest.approx(weight, rel=1e-6)
    assert -5e4 * data.qpos[0] - 5.0 * 9.81 == pytest.approx(weight, rel=1e-4)
    force, carried = np.zeros(6), 0.0
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        carried += force[0]
    assert carried == pytest.approx(weight + 98.1, rel=1e-4)
