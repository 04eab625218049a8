"""Points carried along by others, against rotations and sizes that are known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from halfphysics.base import rotations as rot
from halfphysics.formats.positions.similarity import carried, turn_of

EXACT = 1e-9
RNG = np.random.default_rng(0)
POINTS, OTHERS = RNG.normal(size=(5, 3)), RNG.normal(size=(2, 3))
TURNS = Rotation.random(7, random_state=1).as_matrix()
SIZES, MOVES = RNG.uniform(0.5, 2.0, 7), RNG.normal(size=(7, 3))


def moved(points):
    return SIZES[:, None, None] * np.einsum("tij,nj->tni", TURNS, points) + MOVES[:, None]


def test_a_similarity_is_found():
    assert np.abs(carried(POINTS, moved(POINTS), OTHERS) - moved(OTHERS)).max() < EXACT
    assert np.abs(rot.to_matrix(turn_of(POINTS, moved(POINTS))) - TURNS).max() < EXACT


def test_a_mirror_image_gives_a_rotation_all_the_same():
    mirrored = (POINTS * [-1.0, 1.0, 1.0])[None]
    matrix = rot.to_matrix(turn_of(POINTS, mirrored))[0]
    assert abs(np.linalg.det(matrix) - 1.0) < EXACT


def test_noise_is_averaged():
    """Against scipy's own least squares of directions."""
    noisy = moved(POINTS) + 0.05 * RNG.normal(size=(7, 5, 3))
    own = rot.to_matrix(turn_of(POINTS, noisy))
    for k in range(7):
        a, b = POINTS - POINTS.mean(axis=0), noisy[k] - noisy[k].mean(axis=0)
        assert np.abs(own[k] - Rotation.align_vectors(b, a)[0].as_matrix()).max() < 1e-6
