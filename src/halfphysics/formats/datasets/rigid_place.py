"""Places of one frame in another that data sets keep as 4 x 4 matrices in JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import FileError

Array = NDArray[np.float64]

#: Entries of rotation matrices that were written in single precision, or rounded.
_TOLERANCE = 1e-3
#: Far above any table of a data set [bytes].
_LARGEST = 16 * 2**20


def read_json(path: Path) -> Any:
    """The content of a small JSON file.

    Raises:
        FileError: It cannot be read, or is larger than any such file.
    """
    try:
        size = path.stat().st_size
        if size > _LARGEST:
            raise FileError(
                f"{path}: {size / 2**20:.0f} MiB, expected at most {_LARGEST // 2**20} of JSON"
            )
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise FileError(f"{path}: cannot be read ({error}). Copy it again") from None


def rigid(path: Path, rotation: Any, place: Any) -> tuple[Array, Array]:
    """A rotation (3, 3), exactly orthonormal, and a place (3,).

    Raises:
        FileError: The matrix is no rotation within 1e-3, or these are no numbers.
    """
    try:
        turn = np.asarray(rotation, dtype=np.float64)
        at = np.asarray(place, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        turn, at = np.zeros(0), np.zeros(0)
    fits = turn.shape == (3, 3) and at.shape == (3,) and bool(np.isfinite(turn).all())
    fits = fits and bool(np.isfinite(at).all())
    if not fits or np.abs(turn @ turn.T - np.eye(3)).max() > _TOLERANCE or np.linalg.det(turn) < 0:
        raise FileError(
            f"{path}: found no rotation (3, 3) with a place (3,), expected a rigid transform"
        )
    u, _, v = np.linalg.svd(turn)
    return np.asarray(u @ v), at
