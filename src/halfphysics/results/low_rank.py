"""A table over time as weights times few rows: dents of a thousand vertices need some dozens."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Frames from which the rows of a long table are made.
MOST_FRAMES = 300
# Frames whose further columns are in memory at a time.
_CHUNK = 64

#: Rows (k, w) of a table at some frames (k,).
Rows = Callable[[NDArray[np.integer]], Array]


def low_rank(
    table: Array | NDArray[np.float32],
    tolerance: float,
    most: int,
    beside: Array | Rows | None = None,
) -> tuple[Array, Array, Array]:
    """Weights and rows with weights @ rows = table, to a tolerance.

    Args:
        table: (T, n), one row for each frame; what is left of it is in numbers of its kind.
        tolerance: Largest error of a number, unless that takes more than `most` rows.
        most: Most rows.
        beside: Further columns (T, w), which the same weights give as well as they can; or what
            gives their rows (k, w) at some frames (k,), so that they are never all in memory.

    Returns:
        Weights (T, k), the largest of each column being 1 in size; rows (k, n); rows of `beside`
        (k, w).
    """
    frames, n = table.shape
    some = np.unique(np.linspace(0, frames - 1, min(frames, MOST_FRAMES)).astype(int))

    def whole(at: NDArray[np.integer]) -> Array:
        if beside is None:
            return np.asarray(table[at], dtype=np.float64)
        more = beside(at) if callable(beside) else beside[at]
        return np.concatenate([table[at], more], axis=1)

    chosen = whole(some)
    _, vectors = np.linalg.eigh(chosen @ chosen.T)
    rows = vectors[:, ::-1][:, : min(most, len(some))].T @ chosen  # orthogonal, the largest first
    square = np.maximum((rows**2).sum(axis=1), 1e-300)
    if len(some) == frames:
        weights = (chosen @ rows.T) / square
    else:
        parts = [np.arange(k, min(k + _CHUNK, frames)) for k in range(0, frames, _CHUNK)]
        weights = np.concatenate([whole(part) @ rows.T for part in parts]) / square
    left, used = table.copy(), 0
    while used < len(rows) and max(map(_largest, left), default=0.0) > tolerance:
        for row, weight in zip(left, weights[:, used], strict=True):
            row -= weight * rows[used, :n]
        used += 1
    weights, rows = weights[:, :used], rows[:used]
    scale = np.maximum(np.abs(weights).max(axis=0, initial=0.0), 1e-300)
    rows = rows * scale[:, None]
    return weights / scale, rows[:, :n], rows[:, n:]


def _largest(row: NDArray[np.floating]) -> float:
    return float(np.abs(row).max(initial=0.0))
