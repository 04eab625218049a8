"""Rotations of one joint are those of many."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from halfphysics.actors import turns
from halfphysics.base import rotations as rot
from halfphysics.body import joint_ranges

RNG = np.random.default_rng(0)
VECTORS = [tuple(v) for v in RNG.normal(size=(40, 3)).tolist()]


def test_they_equal_those_of_numpy():
    for a, b in pairwise(VECTORS):
        p, q = turns.exp(a), turns.exp(b)
        np.testing.assert_allclose(p, rot.exp(a), atol=1e-15)
        np.testing.assert_allclose(turns.multiply(p, q), rot.multiply(p, q), atol=1e-15)
        np.testing.assert_allclose(turns.rotate(p, b), rot.rotate(p, b), atol=1e-14)
        np.testing.assert_allclose(turns.log(p), rot.log(p), atol=1e-14)
        half = turns.slerp(p, q, 0.3)
        np.testing.assert_allclose(half, rot.slerp(p, q, 0.3), atol=1e-14)


def test_small_rotations_and_none():
    assert turns.log(turns.NO_TURN) == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(turns.log(turns.exp((1e-14, 0.0, 0.0))), [1e-14, 0, 0], atol=1e-20)
    np.testing.assert_allclose(turns.log((-1.0, 0.0, 0.0, 0.0)), 0.0)


def test_swing_and_twist_equal_those_of_ranges():
    axes = rot.rotvec_to_matrix([0.3, -0.5, 1.1]).T
    own = tuple(tuple(row) for row in axes.tolist())
    for v in VECTORS:
        q = turns.exp(v)
        angles = turns.swing_twist(q, own)
        np.testing.assert_allclose(angles, joint_ranges.swing_twist(q, axes), atol=1e-13)
        there = turns.log(turns.from_swing_twist(angles, own))
        np.testing.assert_allclose(there, turns.log(q), atol=1e-9)


def test_a_frame_has_the_axes_that_were_given():
    for a, b in pairwise(VECTORS):
        q = turns.frame(a, b)
        np.testing.assert_allclose(turns.rotate(q, (1.0, 0.0, 0.0)), turns.unit(a), atol=1e-12)
        assert turns.dot(turns.rotate(q, (0.0, 1.0, 0.0)), b) > 0.0
        assert math.hypot(*q) == pytest.approx(1.0, abs=1e-12)


def test_headings():
    for heading in (0.0, 1.0, -2.5):
        root = turns.multiply(turns.about_z(heading), turns.WORLD_FROM_REST)
        assert turns.heading_of(root) == pytest.approx(heading)
    assert turns.wrapped(3.0 * math.pi) == pytest.approx(math.pi)
    assert turns.wrapped(-math.pi) == pytest.approx(math.pi)
    assert turns.wrapped(0.3) == 0.3
