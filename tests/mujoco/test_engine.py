"""Timesteps that the core makes by itself, and those that Python makes."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.mujoco import engine
from support.mujoco_worlds import spec_of, t_pose


def swing(callback: Callable[..., None] | None = None, steps: int = 60) -> np.ndarray:
    """The arm swings at the person; coordinates of every step."""
    spec = spec_of(x=-1.1, y=-0.45)
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    control = human.bind(model, data)
    data.qpos[0] = data.ctrl[0] = -0.5 * np.pi
    control.reset(t_pose())
    out = []
    mujoco.set_mjcb_control(callback)
    try:
        assert engine.watched() == (callback is not None)
        for i in range(steps):
            data.ctrl[0] = -0.5 * np.pi + 0.8 * min(1.0, i / 40)
            control.step(t_pose(), dt=1.0 / 60.0)
            out.append(np.concatenate([data.qpos, data.qvel, data.mocap_pos.ravel()]))
    finally:
        mujoco.set_mjcb_control(None)
    assert len(control.contacts.part)
    return np.array(out)


def test_step_is_found():
    assert engine.step_address() != 0
    assert not engine.watched()


def test_python_makes_the_same_steps(monkeypatch):
    """Where MuJoCo calls back, and where its library is not found: the same bits."""
    usual = swing()
    calls: list[float] = []
    called_back = swing(lambda _, data: calls.append(data.time))
    assert len(calls) > 60 * 8
    np.testing.assert_array_equal(called_back, usual)
    monkeypatch.setattr(engine, "step_address", lambda: 0)
    np.testing.assert_array_equal(swing(), usual)


def test_an_error_of_mujoco_does_not_end_the_process():
    """A world whose contacts need more memory than it has been given."""
    balls = "".join(
        f'<body pos="{3 + 0.05 * i} 0 1"><freejoint/><geom size="0.2"/></body>' for i in range(8)
    )
    spec = mujoco.MjSpec.from_string(
        f'<mujoco><size memory="8K"/><worldbody>{balls}</worldbody></mujoco>'
    )
    human = hp.attach(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    with pytest.raises(mujoco.FatalError):  # what MuJoCo itself does with it
        mujoco.mj_step(model, data)
    control = human.bind(model, data)
    still = np.zeros(model.nv + 168)
    control._stepper.reset(np.concatenate([data.qpos, control._targets([t_pose()])]), still)
    control._started = True  # `reset` would meet the error in mj_forward
    with pytest.raises(mujoco.FatalError):
        control.step(t_pose(), dt=0.01)
    assert model.opt.timestep == 0.002
