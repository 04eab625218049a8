"""Coordinates of people: rotations there and back."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics import _native
from halfphysics.base import rotations as rot

#: A few roundings of numbers up to pi.
ROUNDING = 2e-15


def turns(count):
    """Rotations of all sizes up to half a turn (count, 55, 3)."""
    rng = np.random.default_rng(3)
    axes = rng.normal(size=(count, 55, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    sizes = rng.choice([0.0, 1e-300, 1e-9, 1e-4, 0.3, 3.0], size=(count, 55, 1))
    return axes * sizes * rng.uniform(0.9, 1.0, size=(count, 55, 1))


def test_quaternions_are_those_of_the_rotations():
    person = hp.Simulator().world.people[0]
    rotations, translation = turns(50), np.random.default_rng(1).normal(size=(50, 3))
    q = person.coordinates(translation, rotations, np.eye(3))
    quats = q[:, person.joint_qpos[:, None] + np.arange(4)]
    assert np.abs(quats - rot.exp(rotations)).max() <= ROUNDING
    assert np.array_equal(q[:, :3], translation + person.body.rest_joints[0])
    back, again = person.pose(q, np.eye(3))
    assert np.abs(again - rotations).max() <= ROUNDING
    assert np.abs(again - rot.log(quats)).max() <= ROUNDING
    assert np.abs(back - translation).max() <= ROUNDING


def test_one_frame_has_the_bits_of_many():
    person = hp.Simulator().world.people[0]
    rotations, translation = turns(9), np.zeros((9, 3))
    q = person.coordinates(translation, rotations, np.eye(3))
    for t in range(9):
        one = person.coordinates(translation[t : t + 1], rotations[t : t + 1], np.eye(3))
        assert np.array_equal(one[0], q[t])
        assert np.array_equal(person.pose(q[t], np.eye(3))[1], person.pose(q, np.eye(3))[1][t])


def test_places_outside_are_refused():
    at, out = np.array([3, 7], dtype=np.int32), np.zeros((1, 10))
    with pytest.raises(ValueError, match="no such place"):
        _native.put_rotations(np.zeros((1, 2, 3)), at, out)
    with pytest.raises(ValueError, match="no such place"):
        _native.rotations_of(out, at - 4)
    with pytest.raises(ValueError, match="another number of frames"):
        _native.put_rotations(np.zeros((2, 1, 3)), at[:1], out)
    with pytest.raises(ValueError, match="one place per joint"):
        _native.put_rotations(np.zeros((1, 3, 3)), at[:1], out)
