"""Many MuJoCo worlds with people, stepped on threads."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from support.mujoco_worlds import spec_of, t_pose


def worlds(count: int = 5, force: float = 60.0) -> list:
    """Worlds of one model: arms that start at different angles, and people whom some hit."""
    spec = spec_of(x=-1.1, y=-0.45, force=force)
    human = hp.attach(spec)
    model = spec.compile()
    out = []
    for i in range(count):
        data = mujoco.MjData(model)
        data.qpos[0] = data.ctrl[0] = -0.5 * np.pi + 0.1 * i
        control = human.bind(model, data)
        control.reset(t_pose())
        out.append((control, data))
    return out


def played(threads: int | None, steps: int = 25) -> tuple[np.ndarray, int]:
    """Coordinates, velocities and sensors of all worlds, and how many steps touched a person."""
    all_worlds, touched = worlds(), 0
    controls = [control for control, _ in all_worlds]
    rows = []
    for _ in range(steps):
        for _, data in all_worlds:
            data.ctrl[0] += 0.03
        if threads is None:
            for control in controls:
                control.step(t_pose(), dt=1.0 / 40.0)
        else:
            hp.step_worlds(controls, [t_pose()] * len(controls), 1.0 / 40.0, threads=threads)
        touched += sum(len(control.contacts.part) > 0 for control in controls)
        rows.append([np.concatenate([d.qpos, d.qvel, d.mocap_pos.ravel()]) for _, d in all_worlds])
    return np.array(rows), touched


def test_same_bits_for_any_number_of_threads():
    alone, touched = played(None)
    assert touched > 10
    for threads in (1, 2, 7):
        np.testing.assert_array_equal(played(threads)[0], alone)


def test_worlds_that_call_back_are_stepped_in_turn():
    usual = step(worlds(2), None)
    np.testing.assert_array_equal(step(worlds(2), lambda *_: None), usual)


def step(all_worlds: list, callback: Callable[..., None] | None) -> np.ndarray:
    """Coordinates after a second step."""
    mujoco.set_mjcb_control(callback)
    try:
        for _ in range(2):
            hp.step_worlds([control for control, _ in all_worlds], [t_pose()] * 2, threads=2)
    finally:
        mujoco.set_mjcb_control(None)
    return np.array([data.qpos for _, data in all_worlds])


def test_mistakes_leave_all_worlds_as_they_are():
    (first, data), (second, _) = worlds(2)
    pose = t_pose()
    with pytest.raises(InputError, match="found 1 poses, expected one per world: 2"):
        hp.step_worlds([first, second], [pose])
    with pytest.raises(InputError, match="two controls of one MjData"):
        hp.step_worlds([first, first], [pose, pose])
    with pytest.raises(InputError, match="controls: found Control, expected a list"):
        hp.step_worlds(first, [pose])
    with pytest.raises(InputError, match="poses: found Pose, expected a list"):
        hp.step_worlds([first, second], pose)
    for threads in (0, 1.5, True, "2"):
        with pytest.raises(InputError, match=r"threads: found .*, expected 1 or more"):
            hp.step_worlds([first], [pose], threads=threads)
    with pytest.raises(InputError, match="found str, expected what bind returned"):
        hp.step_worlds(["first"], [pose])
    with pytest.raises(InputError, match=r"expected a halfphysics\.Pose"):
        hp.step_worlds([first, second], [pose, "upright"])
    with pytest.raises(InputError, match="dt: found 0"):
        hp.step_worlds([first, second], [pose, pose], 0.0)
    mujoco.set_mjcb_control(lambda model, data: None)  # one after the other
    try:
        with pytest.raises(InputError, match=r"expected a halfphysics\.Pose"):
            hp.step_worlds([first, second], [pose, "upright"])
    finally:
        mujoco.set_mjcb_control(None)
    assert data.time == 0.0
    hp.step_worlds([], [])
    hp.step_worlds([first, second], [pose, [pose]], threads=np.int64(2))
    assert data.time == 0.002
