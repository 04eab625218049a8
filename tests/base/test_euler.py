"""Euler angles: exact as rotations everywhere, and continuous."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from halfphysics.base import rotations as rot
from halfphysics.base.euler import from_angles, smoothest, to_angles

ORDERS = list(itertools.permutations(range(3)))
# Within this cosine of gimbal lock the first angle is kept: its error is at most this.
EXACT = 2e-10


@pytest.mark.parametrize("axes", ORDERS)
def test_against_scipy(axes):
    angles = np.random.default_rng(0).normal(0.0, 2.0, (200, 3))
    theirs = Rotation.from_euler("".join("XYZ"[a] for a in axes), angles).as_matrix()
    assert np.abs(rot.to_matrix(from_angles(axes, angles)) - theirs).max() < 1e-14


@pytest.mark.parametrize("axes", [(1,), (0, 2), (2, 2, 1, 0), ()])
def test_any_number_of_turns(axes):
    angles = np.random.default_rng(0).normal(0.0, 2.0, (20, len(axes)))
    expected = Rotation.identity(20)
    for k, axis in enumerate(axes):
        expected = expected * Rotation.from_euler("XYZ"[axis], angles[:, k, None])
    assert np.abs(rot.to_matrix(from_angles(axes, angles)) - expected.as_matrix()).max() < 1e-14


@pytest.mark.parametrize("axes", ORDERS)
def test_there_and_back_with_every_nearness_to_the_lock(axes):
    rng = np.random.default_rng(1)
    angles = rng.uniform(-np.pi, np.pi, (600, 4, 3))
    off = np.concatenate([[0.0], 10.0 ** np.linspace(-17, -1, 199)])[:, None]
    angles[:200, :, 1] = np.pi / 2 - off
    angles[200:400, :, 1] = -np.pi / 2 + off
    turns = from_angles(axes, angles)
    again = from_angles(axes, to_angles(axes, turns))
    assert np.abs(rot.to_matrix(again) - rot.to_matrix(turns)).max() < EXACT


@pytest.mark.parametrize("axes", ORDERS)
def test_smooth_angles_come_back_as_they_were(axes):
    """Beyond whole turns and through gimbal lock, where both triples give the same rotation."""
    t = np.linspace(0.0, 1.0, 500)[:, None]
    angles = np.stack([9.0 * t, 7.0 * np.sin(3.0 * t), -8.0 * t + 0.3], axis=-1)
    assert np.abs(angles[..., 1]).max() > 3.0
    found = to_angles(axes, from_angles(axes, angles))
    assert np.abs(found - angles).max() < 1e-9


def test_what_starts_or_stays_locked_does_not_jump():
    axes, t = (2, 0, 1), np.linspace(0.0, 1.0, 300)
    angles = np.stack([0.7 + 0 * t, np.pi / 2 + np.clip(t - 0.3, 0, 1), 0.2 * t], axis=-1)[:, None]
    found = to_angles(axes, from_angles(axes, angles))
    assert np.abs(np.diff(found, axis=0)).max() < 0.01


def test_the_order_with_the_smoothest_angles():
    """Each of six joints passes the lock of another order; the still joint keeps the usual one."""
    t = np.linspace(0.0, 1.0, 400)
    turns = np.zeros((400, 7, 4))
    turns[:, 6, 0] = 1.0
    for joint, axes in enumerate(ORDERS):
        swing = np.stack([0.2 * t, np.pi / 2 + 0.02 * np.cos(6 * t), 0.05 * np.sin(40 * t)], axis=1)
        turns[:, joint] = from_angles(axes, swing)
        turns[:, joint] = rot.multiply(turns[:, joint], rot.exp([[0.03, 0.02, 0.01]]))
    orders, angles = smoothest(turns, (1, 2, 0))
    assert orders[6] == (1, 2, 0)
    for joint, axes in enumerate(orders):
        again = from_angles(axes, angles[:, joint])
        assert np.abs(rot.to_matrix(again) - rot.to_matrix(turns[:, joint])).max() < EXACT
    step = np.linalg.norm(rot.log(rot.multiply(rot.conjugate(turns[:-1]), turns[1:])), axis=-1)
    change = np.abs(np.diff(angles, axis=0)).max(axis=(0, 2))
    assert (change[:6] < 2.0 * step.max(axis=0)[:6]).all()
    locked = [np.abs(np.diff(to_angles((1, 2, 0), turns), axis=0)).max(axis=(0, 2))]
    assert (locked[0] > 5.0 * change).any()
