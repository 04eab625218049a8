"""Rotations against scipy, an independent implementation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from halfphysics.base import rotations as rot

#: Rounding of a handful of products of numbers near one.
ROUNDING = 1e-14
#: Angles [rad] where series, signs or square roots change: zero, tiny, half turns, whole turns.
ANGLES = [0.0, 1e-300, 1e-9, 1e-3, 1.0, np.pi - 1e-7, np.pi, 4.0, 2 * np.pi - 1e-3]


def scipy_quaternion(turn):
    """Quaternions (..., 4), w first, w >= 0."""
    return turn.as_quat(canonical=True, scalar_first=True)


def drawn(seed, *shape):
    """Rotation vectors (*shape, 3) of every size up to 3 turns."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(*shape, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    return axis * rng.uniform(0.0, 6 * np.pi, size=(*shape, 1))


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_and_logarithm(angle):
    vectors = drawn(0, 50)
    vectors *= angle / np.linalg.norm(vectors, axis=-1, keepdims=True)
    ours, theirs = rot.exp(vectors), Rotation.from_rotvec(vectors)
    np.testing.assert_allclose(rot.to_matrix(ours), theirs.as_matrix(), atol=ROUNDING)
    back = rot.log(ours)
    assert np.linalg.norm(back, axis=-1).max() <= np.pi + ROUNDING
    np.testing.assert_allclose(rot.rotvec_to_matrix(back), theirs.as_matrix(), atol=ROUNDING)
    if angle < np.pi:
        np.testing.assert_allclose(back, vectors, rtol=1e-8, atol=0.0)


def test_products_inverses_and_turned_vectors():
    one, two = drawn(1, 100), drawn(2, 100)
    a, b = Rotation.from_rotvec(one), Rotation.from_rotvec(two)
    product = rot.multiply(rot.exp(one), rot.exp(two))
    np.testing.assert_allclose(rot.to_matrix(product), (a * b).as_matrix(), atol=ROUNDING)
    inverse = rot.to_matrix(rot.conjugate(rot.exp(one)))
    np.testing.assert_allclose(inverse, a.inv().as_matrix(), atol=ROUNDING)
    vectors = np.random.default_rng(3).normal(size=(100, 3))
    np.testing.assert_allclose(rot.rotate(rot.exp(one), vectors), a.apply(vectors), atol=1e-13)
    np.testing.assert_allclose(rot.angles(one, two), (a.inv() * b).magnitude(), atol=1e-7)


@pytest.mark.parametrize("angle", ANGLES)
def test_matrices_of_any_angle_come_back(angle):
    """Near half turns w is 0: the largest component decides the sign."""
    vectors = np.concatenate([np.eye(3), drawn(4, 60)])
    vectors *= angle / np.linalg.norm(vectors, axis=-1, keepdims=True)
    matrices = Rotation.from_rotvec(vectors).as_matrix()
    quaternions = rot.from_matrix(matrices)
    assert (quaternions[:, 0] >= 0.0).all()
    np.testing.assert_allclose(rot.to_matrix(quaternions), matrices, atol=ROUNDING)
    again = rot.rotvec_to_matrix(rot.matrix_to_rotvec(matrices))
    np.testing.assert_allclose(again, matrices, atol=ROUNDING)


def test_between_two_rotations_along_the_shortest_arc():
    start, end = drawn(5, 1)[0], drawn(6, 1)[0]
    times = np.linspace(0.0, 1.0, 11)
    theirs = Slerp([0.0, 1.0], Rotation.from_rotvec([start, end]))(times)
    ours = rot.slerp(np.tile(rot.exp(start), (11, 1)), np.tile(rot.exp(end), (11, 1)), times)
    np.testing.assert_allclose(rot.to_matrix(ours), theirs.as_matrix(), atol=ROUNDING)


def test_quaternions_without_jumps_of_sign():
    smooth = rot.exp(np.linspace(0.1, 6.0, 40)[:, None, None] * drawn(7, 1, 5) / 10.0)
    jumping = smooth * np.random.default_rng(8).choice([-1.0, 1.0], size=(40, 5, 1))
    found = rot.continuous(jumping)
    assert (np.einsum("tik,tik->ti", found[1:], found[:-1]) > 0.0).all()
    np.testing.assert_array_equal(found * np.sign(found[0] / smooth[0])[None], smooth)


def test_any_leading_shape():
    vectors = drawn(9, 2, 3, 4)
    quaternions = rot.exp(vectors)
    assert quaternions.shape == (2, 3, 4, 4)
    flat = Rotation.from_rotvec(vectors.reshape(-1, 3))
    theirs = scipy_quaternion(flat).reshape(2, 3, 4, 4)
    np.testing.assert_allclose(rot.from_matrix(rot.to_matrix(quaternions)), theirs, atol=1e-13)
    assert rot.normalize(3.0 * quaternions).shape == (2, 3, 4, 4)
    np.testing.assert_allclose(rot.normalize(3.0 * quaternions), quaternions, atol=ROUNDING)


@pytest.mark.parametrize("shape", [(), (1,), (7, 5), (0,)])
def test_cross_products_are_those_of_numpy(shape):
    """Bit for bit, broadcast too."""
    numbers = np.random.default_rng(0)
    a, b, c = numbers.normal(size=(*shape, 3)), numbers.normal(size=(*shape, 3)), np.arange(3.0)
    for x, y in ((a, b), (a, c), (c, a)):
        assert np.array_equal(rot.cross(x, y), np.cross(x, y))
