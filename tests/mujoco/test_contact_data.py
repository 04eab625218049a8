"""Contacts of people as MuJoCo has contacts, and the momentum that they stand for."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from support.mujoco_worlds import spec_of, t_pose

#: Rounding of sums of some thousand impulses of up to 1 N s, and of one of them [N s].
SUM, ONE = 1e-11, 1e-13
ALL = mujoco.mjtState.mjSTATE_INTEGRATION


class Push:
    """The arm swings to and fro against the person's right forearm."""

    def __init__(self, **changes: object) -> None:
        spec = spec_of(x=-1.1, y=-0.45, force=60.0)
        human = hp.attach(spec)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.pose = t_pose()
        self.control = human.bind(self.model, self.data, settings=hp.Settings(**changes))
        self.data.qpos[0] = self.data.ctrl[0] = -0.5 * np.pi
        self.control.reset(self.pose)
        self.steps = 0

    def step(self) -> None:
        self.steps += 1
        self.data.ctrl[0] = -0.5 * np.pi + 0.8 * np.sin(2.0 * self.steps * 0.002)
        self.control.step(self.pose)


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_momentum_of_arm_and_person_is_balanced(contact):
    """Impulses on the person, those of the rows, forces on the arm's bodies, and what the arm's
    joints gain over MuJoCo's own step: M^ (v - v*) = sum J^T p."""
    push = Push(contact=contact)
    model, data, control = push.model, push.data, push.control
    free, h = mujoco.MjData(model), model.opt.timestep
    person, arm, touched = np.zeros(3), np.zeros(3), 0
    state = np.zeros(mujoco.mj_stateSize(model, ALL))
    for _ in range(500):
        mujoco.mj_getState(model, data, state, ALL)
        mujoco.mj_setState(model, free, state, ALL)
        free.xfrc_applied[:] = 0.0
        push.step()
        free.ctrl[:] = data.ctrl
        mujoco.mj_step(model, free)
        rows, got = control.contact, control.contacts.impulse.sum(axis=0)
        np.testing.assert_allclose(rows.world_force.sum(axis=0) * h, got, atol=ONE)
        person += got
        arm += h * data.xfrc_applied[:, :3].sum(axis=0)
        touched += len(rows) > 0
        gained, jacobian = np.zeros(model.nv), np.zeros((3, model.nv))
        mujoco.mj_mulM(model, free, gained, data.qvel - free.qvel)
        gained += h * model.dof_damping * (data.qvel - free.qvel)
        for row, force in zip(rows, rows.world_force, strict=True):
            assert model.geom(row.geom2).name.startswith("human/")
            body = model.geom_bodyid[row.geom1]
            mujoco.mj_jac(model, free, jacobian, None, row.pos, body)
            gained += h * jacobian.T @ force
        np.testing.assert_allclose(gained, 0.0, atol=ONE)
    assert touched > 50
    assert np.linalg.norm(person) > 1.0
    np.testing.assert_allclose(person + arm, 0.0, atol=SUM)


def test_fields_are_those_of_mujoco():
    push = Push()
    while not len(push.control.contact):
        push.step()
    rows = push.control.contact
    real = mujoco.MjContact
    for row in rows:
        assert all(hasattr(real, name) for name in ("geom1", "geom2", "pos", "frame", "dist"))
        axes = row.frame.reshape(3, 3)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(axes) > 0.0
        assert row.force[0] > 0.0
        assert push.model.geom(row.geom1).name == "fore"
        # Within friction's cone: the smaller of the geom's 1 and the person's 1.
        assert np.linalg.norm(row.force[1:3]) <= row.force[0] * (1.0 + 1e-6)
    # The normal points from the arm into the person: on it the force is that way.
    assert (np.einsum("ni,ni->n", rows.world_force, rows.frame[:, :3]) > 0.0).all()
    assert repr(rows).startswith("PersonContacts(")


def test_no_contact_no_rows():
    push = Push()
    push.step()
    assert len(push.control.contact) == 0
    assert list(push.control.contact) == []
    assert push.control.contact.force.shape == (0, 6)


def test_forces_in_the_world_are_taken_back_and_others_stay():
    """`xfrc_applied` has the last timestep's forces; what a user writes is the user's."""
    push = Push()
    while not len(push.control.contact):
        push.step()
    fore, upper = push.model.body("fore").id, push.model.body("upper").id
    assert np.abs(push.data.xfrc_applied[fore, :3]).max() > 0.1
    assert not push.data.xfrc_applied[upper].any()
    push.data.xfrc_applied[upper] = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    push.data.xfrc_applied[fore] = (0.0, 0.0, 2.0, 0.0, 0.0, 0.0)
    push.data.qpos[0] -= 1.0  # away from the person
    push.step()
    assert not len(push.control.contact)
    np.testing.assert_array_equal(push.data.xfrc_applied[upper, :3], (0.0, 0.0, 1.0))
    np.testing.assert_array_equal(push.data.xfrc_applied[fore, :3], (0.0, 0.0, 2.0))


@pytest.mark.parametrize("push", [lambda t: 8.0, lambda t: 8.0 + np.sin(t)])
def test_one_number_that_a_user_writes_is_the_users_and_the_others_are_taken_back(push):
    """As whole rows do: the same path, to the last bit."""
    paths = []
    for whole in (True, False):
        it = Push()
        path, fore = [], it.model.body("fore").id
        for t in range(300):
            if whole:
                it.data.xfrc_applied[fore] = (0.0, push(t), 0.0, 0.0, 0.0, 0.0)
            else:
                it.data.xfrc_applied[fore, 1] = push(t)
            it.step()
            path.append(it.data.qpos.copy())
        paths.append(path)
    assert len(it.control.contact)
    np.testing.assert_array_equal(paths[1], paths[0])
