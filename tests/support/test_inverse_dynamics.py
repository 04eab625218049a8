"""Inverse dynamics of moving people against MuJoCo's, and balances of momentum."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.mjcf_person import to_mjcf
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.support.inverse_dynamics import dynamics, joint_power, joint_torques
from support.people import FACING_X

GRAVITY = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def body():
    return hp.Body.default(stature=1.8, mass=80.0)


def swinging(fps, seconds=1.0, seed=2):
    """All joints and the root swing smoothly at about 1 Hz."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * fps)) / fps
    size = 0.4 * rng.normal(size=(55, 3))
    size[22:] *= 0.2
    wave = np.sin(2.0 * np.pi * t[:, None, None] + rng.uniform(0.0, 6.0, (55, 3)))
    rotations = size * wave
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(FACING_X), rot.exp(rotations[:, 0])))
    path = 0.2 * np.sin(2.0 * np.pi * t[:, None] + rng.uniform(0.0, 6.0, 3))
    return hp.Motion(path, rotations, fps)


def test_torques_of_a_moving_person(body):
    """MuJoCo's, from velocities and accelerations of its own coordinates, to a thousandth."""
    fps = 1000.0
    motion = swinging(fps)
    found = dynamics(body, motion, GRAVITY, None)
    torque = joint_torques(found, np.zeros_like(found.wrench))
    expected, wrench = mujoco_inverse(body, motion, 400)
    assert np.abs(torque[400] - expected).max() < 1e-3 * np.abs(expected).max()
    mine = found.wrench[400].sum(axis=0)
    assert np.abs(mine[:3] - wrench).max() < 1e-3 * np.abs(wrench).max()


def mujoco_inverse(body, motion, frame):
    model = mujoco.MjModel.from_xml_string(to_mjcf(body.variant))
    model.opt.gravity[:] = GRAVITY
    model.dof_armature[:] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in JOINT_NAMES]
    poses = []
    for f in (frame - 1, frame, frame + 1):
        x, q = body.joint_frames(motion[f])
        qpos = np.zeros(model.nq)
        qpos[:3], qpos[3:7] = x[0], q[0]
        for k in range(1, 55):
            at = model.jnt_qposadr[model.body_jntadr[ids[k]]]
            qpos[at : at + 4] = rot.exp(motion.rotations[f, k])
        poses.append(qpos)
    before, after = np.zeros(model.nv), np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, before, 1.0 / motion.fps, poses[0], poses[1])
    mujoco.mj_differentiatePos(model, after, 1.0 / motion.fps, poses[1], poses[2])
    data.qpos[:], data.qvel[:] = poses[1], 0.5 * (before + after)
    data.qacc[:] = (after - before) * motion.fps
    mujoco.mj_inverse(model, data)
    torque = np.zeros((55, 3))
    for k in range(55):
        at = model.jnt_dofadr[model.body_jntadr[ids[k]]] + (3 if k == 0 else 0)
        torque[k] = data.qfrc_inverse[at : at + 3]
    return torque, data.qfrc_inverse[:3].copy()


def test_forces_are_the_change_of_momentum(body):
    fps = 1000.0
    motion = swinging(fps)
    found = dynamics(body, motion, GRAVITY, None)
    change = np.gradient(found.momentum, axis=0)[10:-10] * fps
    assert found.mass == pytest.approx(80.0)
    needed = found.wrench.sum(axis=1)[10:-10]
    assert needed[:, :3] == pytest.approx(change - 80.0 * GRAVITY, abs=0.1)
    arm = (found.centre - found.joints[:, 0])[10:-10]
    about = needed[:, 3:] - np.cross(arm, needed[:, :3])
    turned = np.gradient(found.angular_momentum, axis=0)[10:-10] * fps
    assert about == pytest.approx(turned, abs=1e-2 * np.abs(turned).max())


def test_power_is_the_change_of_energy(body):
    """Work of joints and of the root's wrench is the change of kinetic and potential energy."""
    fps = 1000.0
    motion = swinging(fps)
    found = dynamics(body, motion, GRAVITY, None)
    torque = joint_torques(found, np.zeros_like(found.wrench))
    power = joint_power(found, torque)
    assert not power[:, 0].any()
    mass = np.array([part.mass for part in body.variant.parts])
    com = np.array([part.com for part in body.variant.parts])
    inertia = np.array([part.inertia for part in body.variant.parts])
    centre = found.joints + rot.rotate(found.quaternions, np.broadcast_to(com, found.joints.shape))
    speed = np.gradient(centre, axis=0) * fps
    own = rot.rotate(rot.conjugate(found.quaternions), found.spin)
    energy = 0.5 * np.einsum("k,tki,tki->t", mass, speed, speed)
    energy += 0.5 * np.einsum("tki,kij,tkj->t", own, inertia, own)
    energy -= np.einsum("k,tki,i->t", mass, centre, GRAVITY)
    root = found.wrench.sum(axis=1)
    pelvis = np.gradient(found.joints[:, 0], axis=0) * fps
    supplied = power.sum(axis=1) + (root[:, :3] * pelvis).sum(axis=1)
    supplied += (root[:, 3:] * found.spin[:, 0]).sum(axis=1)
    change = np.gradient(energy) * fps
    assert supplied[10:-10] == pytest.approx(change[10:-10], abs=1e-2 * np.abs(change).max())
