"""Points carried along by others: in every frame the rotation of least squares (Kabsch 1976) and a
size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]


def turn_of(ours: Array, theirs: Array) -> Array:
    """Rotations (T, 4) that take directions from their middle of `ours` (n, 3) to `theirs`
    (T, n, 3)."""
    a, b = _about(ours), _about(theirs)
    left, _, right = np.linalg.svd(np.einsum("tki,kj->tij", b, a))
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    return rot.from_matrix(left @ right)


def carried(ours: Array, theirs: Array, points: Array) -> Array:
    """Where `points` (k, 3) go with the similarity that takes `ours` (n, 3) to `theirs` (T, n, 3).

    Returns:
        (T, k, 3).
    """
    size = np.linalg.norm(_about(theirs), axis=(1, 2)) / np.linalg.norm(_about(ours))
    turn = turn_of(ours, theirs)
    from_middle = rot.rotate(turn[:, None], points - ours.mean(axis=0))
    return np.asarray(theirs.mean(axis=1)[:, None] + size[:, None, None] * from_middle)


def _about(points: Array) -> Array:
    return np.asarray(points - points.mean(axis=-2, keepdims=True))
