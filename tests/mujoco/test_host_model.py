"""What people meet in a MuJoCo world: its geoms, each other, themselves."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.body.mjcf_person import add_person
from halfphysics.errors import InputError
from support import self_touch as st
from support.mujoco_worlds import spec_of, t_pose


def aside(pose: hp.Pose, x: float) -> hp.Pose:
    return hp.Pose(pose.translation + np.array([x, 0.0, 0.0]), pose.rotations)


@pytest.mark.parametrize("contact", ["skin", "parts"])
def test_people_push_each_other(contact):
    """Two people whose hands meet: they are kept apart, and each gets what the other loses."""
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><geom name="floor" type="plane" size="5 5 0.1"/></worldbody></mujoco>'
    )
    people = [hp.attach(spec, prefix=prefix) for prefix in ("a/", "b/")]
    model = spec.compile()
    data = mujoco.MjData(model)
    control = hp.bind(model, data, people, settings=hp.Settings(contact=contact))
    assert control.names == ("floor", "a", "b")
    start = t_pose()
    control.reset([start, aside(start, 2.2)])
    touched = 0
    for i in range(1, 31):
        control.step([aside(start, 0.02 * i), aside(start, 2.2 - 0.02 * i)], dt=1.0 / 30.0)
        rows = control.contacts
        touched += len(rows.part) > 0
        each = [rows.impulse[rows.person == p].sum(axis=0) for p in (0, 1)]
        np.testing.assert_array_equal(each[0], -each[1])
    assert touched > 10
    one, other = (pose.translation[0] for pose in control.poses)
    # Asked for are 1.0 m between them, arms straight; hands take 1.5 m.
    assert other - one > 1.0
    assert not data.xfrc_applied.any()  # nothing of the world was touched
    for row in control.contact:
        names = {model.geom(row.geom1).name[:2], model.geom(row.geom2).name[:2]}
        assert names == {"a/", "b/"}
    assert control.torques.shape == (2, 55, 3)
    np.testing.assert_array_equal(control.torque, control.torques[0])


def test_one_of_two_people_becomes_limp():
    spec = mujoco.MjSpec.from_string("<mujoco/>")
    people = [hp.attach(spec, prefix=prefix) for prefix in ("a/", "b/")]
    model = spec.compile()
    control = hp.bind(model, mujoco.MjData(model), people)
    control.reset([t_pose(), aside(t_pose(), 3.0)])
    control.set_stiffness(0.0, person=1)
    state = control.get_state()
    control.set_stiffness(5.0)
    control.set_state(state)
    kept = control._stiffness[:, 1:]  # the root has none
    np.testing.assert_array_equal(kept, np.stack([np.ones(54), np.zeros(54)]))
    with pytest.raises(InputError, match="found 'a/', 'a/', expected people of different prefixes"):
        hp.bind(model, mujoco.MjData(model), [people[0], people[0]])


def test_self_contact_is_the_simulators():
    """A clap, in a MuJoCo world and in a world of our own: the same contacts and poses."""
    body = hp.Body.default()
    motion = st.between([st.clap(body, -0.25), st.clap(body, 0.05), st.clap(body, -0.25)], [8, 8])
    settings = hp.Settings(self_contact=True, weight=False)
    spec = mujoco.MjSpec.from_string("<mujoco/>")
    human = hp.attach(spec)
    model = spec.compile()
    model.opt.timestep = 1.0 / motion.fps / 8
    control = human.bind(model, mujoco.MjData(model), settings=settings)
    simulator = hp.Simulator(body=body, settings=replace(settings, substeps=8), fps=motion.fps)
    control.reset(motion[0])
    simulator.reset(motion[0])
    clapped = 0
    for t in range(1, len(motion)):
        control.step(motion[t], dt=1.0 / motion.fps)
        frame = simulator.step(motion[t])
        np.testing.assert_allclose(control.pose.rotations, frame.pose.rotations, atol=1e-9)
        np.testing.assert_allclose(
            control.contacts.impulse, frame.contacts.impulse, rtol=0.0, atol=1e-9
        )
        clapped += len(frame.contacts.part) > 0
    assert clapped > 2


def test_a_person_of_another_kind_is_refused():
    spec = spec_of()
    human = hp.attach(spec)
    other = spec_of()
    add_person(other, human.body.variant, "human/")
    model = other.compile()
    with pytest.raises(InputError, match="are no mocap bodies"):
        human.bind(model, mujoco.MjData(model))
