"""What MuJoCo reads of its model in every step: people see the same masses, gravity and ties."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from support.mujoco_worlds import HEIGHT, t_pose

#: Rounding of sums of some hundred impulses of up to 10 N s [N s].
SUM = 1e-9
BOX = """<mujoco><option timestep="0.002" gravity="0 0 0"/><worldbody><body name="box">
  <freejoint/><geom name="box" type="box" size=".15 .15 .15" mass="2"/></body></worldbody>
  </mujoco>"""
PLATE = """<mujoco><option timestep="0.002"/><worldbody><body name="plate" pos="0 0 -0.1">
  <freejoint/><geom name="plate" type="box" size="1 1 .1" mass="60"/></body></worldbody></mujoco>"""


def world(text):
    spec = mujoco.MjSpec.from_string(text)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    return model, data, human.bind(model, data, settings=hp.Settings(contact="parts"))


@pytest.mark.parametrize("when", ["before reset", "between steps"])
def test_a_mass_that_is_changed_later_balances_the_momentum(when):
    model, data, control = world(BOX)

    def heavier():
        model.body_mass[1] *= 10.0
        model.body_inertia[1] *= 10.0
        mujoco.mj_setConst(model, data)

    if when == "before reset":
        heavier()
    data.qpos[:3] = 0.0, -0.8, HEIGHT + 0.1
    control.reset(t_pose())
    if when == "between steps":
        heavier()
    data.qvel[1] = 2.0
    impulse, h = np.zeros(3), model.opt.timestep
    for _ in range(300):
        control.step(t_pose())
        if len(control.contact):
            impulse -= h * control.contact.world_force.sum(axis=0)
    assert np.linalg.norm(impulse) > 10.0  # of 20 kg that come with 2 m/s
    gained = 20.0 * (data.qvel[:3] - (0.0, 2.0, 0.0))
    np.testing.assert_allclose(gained, impulse, atol=SUM)


@pytest.mark.parametrize("how", ["flag", "changed"])
def test_without_gravity_nobody_weighs_on_anything(how):
    off = '<option timestep="0.002"><flag gravity="disable"/></option>'
    text = PLATE.replace('<option timestep="0.002"/>', off) if how == "flag" else PLATE
    model, data, control = world(text)
    if how == "changed":
        model.opt.gravity[:] = 0.0
    control.reset(t_pose())
    for _ in range(50):
        control.step(t_pose())
    assert not data.xfrc_applied.any()
    assert not data.qvel.any()
    if how == "flag":
        return
    model.opt.gravity[2] = -9.81
    control.step(t_pose())
    assert data.xfrc_applied[1, 2] < -500.0


def test_an_impossible_mass_is_refused_and_changes_nothing():
    model, data, control = world(BOX)
    data.qpos[:3] = 3.0, 0.0, 1.0
    control.reset(t_pose())
    model.body_mass[1] = -1.0
    with pytest.raises(InputError, match="step: MjModel: model: a mass"):
        control.step(t_pose())
    model.body_mass[1] = 2.0
    control.step(t_pose())
    assert data.time == pytest.approx(model.opt.timestep)


TIED = """<mujoco><option timestep="0.002"/><worldbody>
  <body name="cup" pos="0 0 3"><freejoint/><geom type="sphere" size=".03" mass=".2" contype="0"
  conaffinity="0"/></body></worldbody></mujoco>"""


def carried(watched):
    """The cup's path while a hand to which it is tied goes where nothing is."""
    spec = mujoco.MjSpec.from_string(TIED)
    human = hp.attach(spec)
    tie = spec.add_equality()
    tie.type, tie.objtype = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_BODY
    tie.name1, tie.name2 = "human/right_wrist", "cup"
    model = spec.compile()
    model.eq_data[0, :6] = 0.0
    data = mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(contact="parts"))
    motion, path = hp.scenarios.load("walk_into_wall").motion, []
    control.reset(motion[0])
    data.qpos[:3] = data.xpos[model.body("human/right_wrist").id]
    if watched:  # Python makes the timesteps, and people are shown before each
        mujoco.set_mjcb_control(lambda model, data: None)
    try:
        for t in range(1, 15):
            control.step(motion[t], dt=1.0 / motion.fps)
            path.append(np.concatenate([data.qpos, data.qvel]))
    finally:
        mujoco.set_mjcb_control(None)
    return np.array(path)


def test_what_is_tied_to_a_hand_follows_it_at_every_timestep():
    np.testing.assert_array_equal(carried(watched=False), carried(watched=True))
