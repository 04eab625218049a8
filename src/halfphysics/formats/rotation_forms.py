"""Rotations as people store them, to axis-angle: vectors, matrices, and their first two rows or
columns ("6D").

The number of frames says which it is: a joint has 3, 9 or 6 numbers. Two forms of 6D are about:
two vectors after each other (pytorch3d's rows), and interleaved, as the first two columns of a
matrix are in memory (SPIN, HMR). In either the two vectors are orthogonal and of unit length in
one reading only.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.arrays import as_array
from halfphysics.formats.checked_fields import Record

Array = NDArray[np.float64]

#: Numbers for one joint.
VECTOR, SIX, MATRIX = 3, 6, 9
#: Matrices in single or half precision are orthogonal to this; estimators leave more.
_ORTHOGONAL = 0.05


def numbers_of(record: Record, key: str) -> Array:
    """A field of any shape, as finite numbers; raises `FileError`."""
    try:
        axes = np.ndim(as_array(record.raw(key)))
    except (TypeError, ValueError):
        axes = 1  # `array` refuses it
    return record.array(key, *[None] * axes)


def widths(joints: int) -> tuple[int, ...]:
    """Numbers that a field of so many joints may have for one frame."""
    return tuple(joints * size for size in (VECTOR, SIX, MATRIX))


def rows_of(record: Record, key: str, frames: int, allowed: tuple[int, ...]) -> Array:
    """A field as rows (frames, n) with n one of `allowed`; one row stands for every frame.

    Raises:
        FileError: It has another shape, or NaN.
    """
    array = numbers_of(record, key)
    shape = array.shape
    while len(shape) > 1 and shape[0] == 1:
        shape = shape[1:]
    size = math.prod(shape[1:])
    if (frames == 1 or shape[:1] == (frames,)) and array.size in {frames * n for n in allowed}:
        return array.reshape(frames, -1)
    if array.size in allowed:
        return np.repeat(array.reshape(1, -1), frames, axis=0)
    if len(shape) > 1 and size in allowed:
        raise record.error(
            key,
            f"found {shape[0]} rows, expected {frames} as in the translation: fields of different "
            "length",
        )
    wanted = " or ".join(f"({frames}, {n})" for n in allowed)
    raise record.error(key, f"found shape {array.shape}, expected {wanted}")


def vectors(record: Record, key: str, rows: Array, joints: int, *, columns: bool = False) -> Array:
    """Axis-angle (T, joints, 3) [rad] of rows (T, n) of one of `widths`.

    Args:
        record, key: For messages.
        rows: The numbers.
        joints: Number of joints.
        columns: Two vectors after each other are columns of the matrix, not rows.

    Raises:
        FileError: They are no rotations.
    """
    size = rows.shape[1] // joints
    if size == VECTOR:
        return rows.reshape(-1, joints, 3)
    if size == MATRIX:
        return rot.matrix_to_rotvec(checked_matrices(record, key, rows.reshape(-1, joints, 3, 3)))
    pairs = rows.reshape(-1, joints, 6)
    together, apart = pairs.reshape(-1, joints, 2, 3), pairs.reshape(-1, joints, 3, 2)
    apart = np.swapaxes(apart, 2, 3)
    if _skew(together) <= _skew(apart):
        return rot.matrix_to_rotvec(_completed(record, key, together, rows=not columns))
    return rot.matrix_to_rotvec(_completed(record, key, apart, rows=False))


def checked_matrices(record: Record, key: str, matrices: Array) -> Array:
    """Matrices (..., 3, 3), refused where they are no rotations."""
    product = matrices @ np.swapaxes(matrices, -1, -2)
    off = np.abs(product - np.eye(3)).max(axis=(-1, -2))
    bad = (off > _ORTHOGONAL) | (np.linalg.det(matrices) < 0.0)
    if bad.any():
        frame = int(np.argwhere(bad)[0][0])
        raise record.error(
            key, f"the matrix of frame {frame} is no rotation; expected orthonormal 3 x 3 matrices"
        )
    return matrices


def _skew(pairs: Array) -> float:
    """How far pairs of vectors (..., 2, 3) are from unit length and a right angle."""
    products = pairs @ np.swapaxes(pairs, -1, -2)
    return float(np.median(np.abs(products - np.eye(2)).max(axis=(-1, -2)))) if pairs.size else 0.0


def _completed(record: Record, key: str, pairs: Array, *, rows: bool) -> Array:
    """Matrices (..., 3, 3) whose first two rows, or columns, are along pairs (..., 2, 3)."""
    first, second = pairs[..., 0, :], pairs[..., 1, :]
    length = np.linalg.norm(first, axis=-1, keepdims=True)
    third = np.cross(first, second)
    area = np.linalg.norm(third, axis=-1, keepdims=True)
    if min(length.min(initial=1.0), area.min(initial=1.0)) < _ORTHOGONAL:
        raise record.error(key, "two vectors of a joint are zero or parallel, expected rotations")
    first, third = first / length, third / area
    second = np.cross(third, first)
    return np.stack([first, second, third], axis=-2 if rows else -1)
