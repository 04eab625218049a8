"""Unity's axes: left-handed, y up, z ahead, x to the right; quaternions x, y, z, w.

The mirror between them and SMPL-X's rest axes (right-handed, y up, z ahead, x to the left) is at
x = 0: a person who faces +z and has no rotations is the same in both.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

_MIRROR = np.array([-1.0, 1.0, 1.0])
_TO_UNITY = np.array([1.0, -1.0, -1.0, 1.0])
_FROM_UNITY = np.array([1.0, 1.0, -1.0, -1.0])


def position(vectors: ArrayLike) -> Array:
    """Positions (..., 3) mirrored, from Unity to y up and right-handed or back."""
    mirrored: Array = np.asarray(vectors, dtype=np.float64) * _MIRROR
    return mirrored


def from_xyzw(quaternions: ArrayLike) -> Array:
    """Rotations w, x, y, z (..., 4), right-handed, of Unity's x, y, z, w."""
    q = np.asarray(quaternions, dtype=np.float64)
    mirrored: Array = q[..., [3, 0, 1, 2]] * _FROM_UNITY
    return mirrored


def to_xyzw(quaternions: ArrayLike) -> Array:
    """Unity's x, y, z, w of rotations w, x, y, z (..., 4), right-handed."""
    q = np.asarray(quaternions, dtype=np.float64)
    mirrored: Array = q[..., [1, 2, 3, 0]] * _TO_UNITY
    return mirrored
