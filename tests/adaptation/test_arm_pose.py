"""Arms whose hands are moved, by inverse kinematics next to what was recorded."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import arm_pose
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.base import rotations as rot
from support.bent_arms import bent, where

#: A hand is where it should be to this [m] and [rad] (20 rounds, damped).
REACHED, TURNED = 1e-4, 2e-3
#: Derivatives by central differences of 1e-6 rad.
STEP, DIFFERENCE = 1e-6, 1e-8
#: How far a forearm is out of the plane in which its elbow bends [rad].
HINGE = 1e-9


@pytest.mark.parametrize("side", SIDES)
def test_a_hand_goes_where_it_is_asked_to(side):
    body, motion, rng = hp.Body.default(), bent(), np.random.default_rng(5)
    hand = Hand.of(body, side)
    wrist, turn = where(motion, hand, body)
    wrist = wrist + rng.uniform(-0.03, 0.03, wrist.shape)
    turn = rot.rotvec_to_matrix(rng.uniform(-0.2, 0.2, wrist.shape)) @ turn
    frames = np.arange(len(motion))
    rotations = np.array(motion.rotations)
    rotations[:, list(hand.arm)] = arm_pose.moved(motion, body, hand, frames, wrist, turn)
    got_wrist, got_turn = where(motion.with_frames(motion.translation, rotations), hand, body)
    assert np.linalg.norm(got_wrist - wrist, axis=1).max() < REACHED
    off = rot.matrix_to_rotvec(got_turn @ np.swapaxes(turn, 1, 2))
    assert np.linalg.norm(off, axis=1).max() < TURNED


def test_a_hand_that_is_to_stay_stays():
    body, motion = hp.Body.default(), bent()
    hand = Hand.of(body, "left")
    wrist, turn = where(motion, hand, body)
    got = arm_pose.moved(motion, body, hand, np.arange(len(motion)), wrist, turn)
    assert np.abs(got - motion.rotations[:, list(hand.arm)]).max() < 1e-12


def test_out_of_reach_is_approached():
    body, motion = hp.Body.default(), bent()
    hand = Hand.of(body, "left")
    wrist, turn = where(motion, hand, body)
    far = wrist + np.array([0.0, 0.0, 3.0])
    rotations = np.array(motion.rotations)
    frames = np.arange(len(motion))
    rotations[:, list(hand.arm)] = arm_pose.moved(motion, body, hand, frames, far, turn)
    got, _ = where(motion.with_frames(motion.translation, rotations), hand, body)
    assert np.all(np.isfinite(rotations))
    assert np.all(np.linalg.norm(far - got, axis=1) < np.linalg.norm(far - wrist, axis=1) - 0.1)


def test_jacobians_are_derivatives():
    rng = np.random.default_rng(2)
    base, at = rot.rotvec_to_matrix(rng.normal(size=(1, 3))), rng.normal(size=(1, 3))
    local = [rot.rotvec_to_matrix(rng.normal(size=(1, 3))) for _ in range(3)]
    bones = [rng.normal(size=3) for _ in range(2)]
    turns, places = arm_pose.chain(base, at, local, bones)
    tool = np.swapaxes(turns[-1], 1, 2) @ rng.normal(size=3)
    point = places[-1] + np.einsum("nij,nj->ni", turns[-1], tool)
    jacobian = arm_pose.jacobians(turns, places, point)[0]
    for column in range(9):
        ends = []
        for sign in (1.0, -1.0):
            turn = np.zeros(3)
            turn[column % 3] = sign * STEP
            changed = list(local)
            changed[column // 3] = changed[column // 3] @ rot.rotvec_to_matrix(turn[None])
            t, p = arm_pose.chain(base, at, changed, bones)
            ends.append((p[-1] + np.einsum("nij,nj->ni", t[-1], tool), t[-1]))
        (a, ra), (b, rb) = ends
        assert np.abs((a - b)[0] / (2 * STEP) - jacobian[:3, column]).max() < DIFFERENCE
        spin = rot.matrix_to_rotvec(ra @ np.swapaxes(rb, 1, 2))[0] / (2 * STEP)
        assert np.abs(spin - jacobian[3:, column]).max() < DIFFERENCE


@pytest.mark.parametrize("side", SIDES)
def test_an_elbow_stays_a_hinge(side):
    """It bends and twists, and not sideways, wherever the hand goes."""
    body, rng = hp.Body.default(), np.random.default_rng(3)
    hand = Hand.of(body, side)
    rotations = np.array(bent().rotations)
    rotations[:, hand.arm[1]] = [0.0, -1.2 if side == "left" else 1.2, 0.0]
    motion = hp.Motion(np.zeros((6, 3)), rotations, fps=30.0)
    wrist, turn = where(motion, hand, body)
    wrist = wrist + rng.uniform(-0.05, 0.05, wrist.shape)
    turn = rot.rotvec_to_matrix(rng.uniform(-0.5, 0.5, wrist.shape)) @ turn
    got = arm_pose.moved(motion, body, hand, np.arange(6), wrist, turn)
    # The forearm's own axis stays at right angles to the hinge, y of the upper arm.
    bone = rot.rotvec_to_matrix(got[:, 1])[:, :, 0]
    assert np.abs(bone[:, 1]).max() < HINGE
    assert np.abs(got[:, 1] - rotations[:, hand.arm[1]]).max() > 0.05
