"""How far targets go inwards: the inertia of the arm against MuJoCo's, and forces reached."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import press
from halfphysics.adaptation.arm_pose import chain
from halfphysics.adaptation.hands import Hand
from halfphysics.base import rotations as rot
from halfphysics.body.mjcf_person import to_mjcf
from halfphysics.motion.skeleton import PARENTS
from support.bent_arms import bent, where

#: Entries of an inertia matrix [kg m^2]; armatures of fingers are no part of it.
INERTIA = 1e-6
FORCE, FIRM, TAU = 60.0, 1.0, 0.02


def test_the_inertia_is_mujoco_s():
    """M of collar, shoulder and elbow with all other joints at rest, from the MJCF of the body."""
    body = hp.Body.default()
    hand = Hand.of(body, "left")
    motion = bent(2)
    model = mujoco.MjModel.from_xml_string(to_mjcf(body.variant))
    data = mujoco.MjData(model)
    quats = rot.exp(motion.rotations[0])
    data.qpos[3:7] = quats[0]
    for j in range(1, 55):
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, hp.JOINT_NAMES[j])
        data.qpos[model.jnt_qposadr[joint] : model.jnt_qposadr[joint] + 4] = quats[j]
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    dofs = []
    for j in hand.pressing[:-1]:
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, hp.JOINT_NAMES[j])
        dofs += [int(model.jnt_dofadr[joint]) + k for k in range(3)]
    expected = full[np.ix_(dofs, dofs)] - np.diag(model.dof_armature[dofs])
    positions, quaternions = body.joint_frames(motion)
    rest = np.asarray(body.rest_joints)
    joints = hand.pressing
    local = [rot.to_matrix(rot.exp(motion.rotations[:, j])) for j in joints]
    bones = [rest[b] - rest[a] for a, b in itertools.pairwise(joints)]
    base = rot.to_matrix(quaternions[:, PARENTS[joints[0]]])
    turns, places = chain(base, positions[:, joints[0]], local, bones)
    found = press._inertia(body, hand, turns, places, positions, quaternions)[0]
    assert np.abs(found - expected).max() < INERTIA


@pytest.mark.parametrize("side", ["left", "right"])
def test_more_force_goes_farther_in_its_direction(side):
    body, motion = hp.Body.default(), bent(2)
    hand, frames = Hand.of(body, side), np.arange(1)
    inward = np.array([[0.0, -1.0 if side == "left" else 1.0, 0.0]])
    before, _ = where(motion, hand, body)
    ways = []
    for force in (0.5 * FORCE, FORCE):
        rotations = np.array(motion.rotations)
        rotations[:, list(hand.pressing)] = press.pressed(
            motion, body, hand, frames, force * inward, stiffness=FIRM, time=TAU
        )
        after, _ = where(motion.with_frames(motion.translation, rotations), hand, body)
        ways.append(float(((after - before) @ inward[0])[0]))
    assert 0.002 < ways[0] < ways[1] < 0.1
    assert ways[1] == pytest.approx(2.0 * ways[0], rel=0.1)


def test_fingers_turn_inwards_as_the_force_grows():
    """The wrist's spring at that angle has the fingers' share."""
    body = hp.Body.default()
    hand = Hand.of(body, "left")
    angles = press._curl(body, hand, np.array([0.0, FORCE, 2.0 * FORCE]), FIRM, TAU)
    assert angles[0] == 0.0
    assert angles[2] == pytest.approx(2.0 * angles[1])
    model = mujoco.MjModel.from_xml_string(to_mjcf(body.variant))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, "left_wrist")
    dof = int(model.jnt_dofadr[joint])
    inertia = np.trace(full[dof : dof + 3, dof : dof + 3]) / 3.0 - model.dof_armature[dof]
    fingers = body.rest_joints[list(hand.fingers)] - body.rest_joints[hand.wrist]
    lever = np.linalg.norm(fingers, axis=1).max()
    moment = (1.0 + FIRM) * inertia * angles[1] / TAU**2
    assert moment == pytest.approx(press._TIPS_BEAR * FORCE * lever, rel=1e-6)


def test_a_hand_that_presses_is_firmer_and_nothing_else():
    hand = Hand.of(hp.Body.default(), "right")
    firmer = press.firmer(hand, np.array([0.0, 0.5, 1.0]))
    assert (firmer[0] == 1.0).all()
    assert np.allclose(firmer[1] - 1.0, 0.5 * (firmer[2] - 1.0))
    own = [*hand.pressing, *hand.fingers]
    assert (firmer[2, own] > 1.0).all()
    assert (np.delete(firmer[2], own) == 1.0).all()


def test_no_force_changes_nothing():
    body, motion = hp.Body.default(), bent(2)
    hand = Hand.of(body, "left")
    got = press.pressed(
        motion, body, hand, np.arange(2), np.zeros((2, 3)), stiffness=FIRM, time=TAU
    )
    assert np.abs(got - motion.rotations[:, list(hand.pressing)]).max() < 1e-12
