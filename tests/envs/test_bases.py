"""Bases: rests of motors from velocities."""

import numpy as np
import pytest

from halfphysics.envs.bases import LEASH, Bases, ahead, into, wrapped

DT = 1.0 / 30.0
ON = np.ones(2, dtype=bool)


def test_rests_move_as_told_and_stay_within_the_leash():
    bases = Bases(2)
    assert bases.start(0, np.array([1.0, 2.0]), 0.5) == {
        "robot/x": 1.0,
        "robot/y": 2.0,
        "robot/yaw": 0.5,
    }
    now, velocity = bases.told.copy(), np.array([[0.6, 0.0, 0.9], [0.0, 0.0, 0.0]])
    told = bases.drive(now, velocity, DT, ON)
    assert told[0] == pytest.approx([1.02, 2.0, 0.53])
    for _ in range(30):  # the base does not get anywhere
        told = bases.drive(now, velocity, DT, ON)
    assert told[0] - now[0] == pytest.approx([LEASH[0], 0.0, LEASH[2]])
    still = bases.drive(now, -velocity, DT, ~ON)
    assert np.array_equal(still, told)


def test_frames_of_bases():
    yaw = np.array([0.5 * np.pi])
    assert np.stack(ahead(np.array([2.0]), yaw), axis=1)[0] == pytest.approx([0.0, 2.0])
    assert into(np.array([[0.0, 2.0]]), yaw)[0] == pytest.approx([2.0, 0.0])
    assert wrapped(np.array([3.5 * np.pi])) == pytest.approx(-0.5 * np.pi)
