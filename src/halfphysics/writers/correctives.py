"""Pose blend shapes reduced to the few shapes that a take needs, for formats with morph targets.

SMPL models add B vec(R_local - I) to the skin at rest: 486 columns B of V x 3 numbers, 60 MB. A
take uses few directions of that space: with the features F (T, 486) of its frames, the singular
value decomposition of their offsets C = F B^T (T, 3 V) gives weights and shapes; a few dozen are
enough. With F = Q R, the eigenvectors of C C^T are Q times those of (R B^T)(R B^T)^T, so no array
is larger than 486 x 3 V for takes of any length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]

#: Largest error of a vertex at rest, relative to all shapes [m].
TOLERANCE = 5e-6


def correctives(
    posedirs: Array, rotations: Array, tolerance: float = TOLERANCE
) -> tuple[Array, Array]:
    """Shapes and their weights in every frame: weights @ shapes are the offsets of the pose.

    Args:
        posedirs: Pose blend shapes [m], shape (V, 3, 486).
        rotations: Axis-angle [rad] in the parents' frames, shape (T, 55, 3).
        tolerance: Bound on the error of any vertex in any frame [m].

    Returns:
        Shapes (k, V, 3) [m] and weights (T, k), the largest of each shape being 1.
    """
    turned = rot.rotvec_to_matrix(rotations[:, 1:]) - np.eye(3)
    basis, few = np.linalg.qr(turned.reshape(len(rotations), -1))  # F = basis @ few
    offsets = few @ posedirs.reshape(-1, posedirs.shape[2]).T  # C = basis @ offsets
    _, vectors = np.linalg.eigh(offsets @ offsets.T)
    vectors = vectors[:, ::-1]  # the largest first
    weights = basis @ vectors
    shapes = (vectors.T @ offsets).reshape(-1, len(posedirs), 3)
    # The shapes from k on move a vertex by at most |weights| |shapes| (Cauchy-Schwarz).
    left = _tail(np.square(weights)).max(axis=1) * _tail(np.square(shapes).sum(axis=2).T).max(
        axis=1
    )
    count = int(np.argmax(left <= tolerance**2))
    weights, shapes = weights[:, :count], shapes[:count]
    scale = np.abs(weights).max(axis=0, initial=1e-300)
    return shapes * scale[:, None, None], weights / scale


def _tail(rows: Array) -> Array:
    """Sums of the last n - k columns of `rows` (m, n), for k = 0 to n: shape (n + 1, m)."""
    sums = np.cumsum(rows[:, ::-1], axis=1)[:, ::-1]
    return np.concatenate([sums, np.zeros((len(rows), 1))], axis=1).T
