"""A table over time as weights times few rows: dents of a thousand vertices need some dozens."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Frames from which the rows of a long table are made.
MOST_FRAMES = 300


def low_rank(
    table: Array, tolerance: float, most: int, beside: Array | None = None
) -> tuple[Array, Array, Array]:
    """Weights and rows with weights @ rows = table, to a tolerance.

    Args:
        table: (T, n), one row for each frame.
        tolerance: Largest error of a number, unless that takes more than `most` rows.
        most: Most rows.
        beside: Further columns (T, w), which the same weights give as well as they can.

    Returns:
        Weights (T, k), the largest of each column being 1 in size; rows (k, n); rows of `beside`
        (k, w).
    """
    table = np.asarray(table, dtype=np.float64)
    frames, n = table.shape
    whole = table if beside is None else np.concatenate([table, beside], axis=1)
    some = np.unique(np.linspace(0, frames - 1, min(frames, MOST_FRAMES)).astype(int))
    chosen = whole[some]
    _, vectors = np.linalg.eigh(chosen @ chosen.T)
    rows = vectors[:, ::-1][:, : min(most, len(some))].T @ chosen  # orthogonal, the largest first
    square = np.maximum((rows**2).sum(axis=1), 1e-300)
    weights = (whole @ rows.T) / square
    left, used = table.copy(), 0
    while used < len(rows) and np.abs(left).max(initial=0.0) > tolerance:
        left -= weights[:, used, None] * rows[used, :n]
        used += 1
    weights, rows = weights[:, :used], rows[:used]
    scale = np.maximum(np.abs(weights).max(axis=0, initial=0.0), 1e-300)
    rows = rows * scale[:, None]
    return weights / scale, rows[:, :n], rows[:, n:]
