"""Rotations: axis-angle vectors [rad], unit quaternions (wxyz) and matrices, vectorised.

All functions take arrays with any leading shape and return float64. A rotation maps
vectors of the child's frame into the parent's: ``v_parent = R v_child``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def exp(rotvec: ArrayLike) -> Array:
    """Unit quaternions (..., 4) of axis-angle vectors (..., 3)."""
    rotvec = np.asarray(rotvec, dtype=np.float64)
    half = 0.5 * np.linalg.norm(rotvec, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * rotvec], axis=-1)


def log(quat: ArrayLike) -> Array:
    """Axis-angle vectors (..., 3) of unit quaternions (..., 4), the shortest arc: |.| <= pi."""
    quat = np.asarray(quat, dtype=np.float64)
    w, v = quat[..., :1], quat[..., 1:]
    sign = np.where(w < 0.0, -1.0, 1.0)
    norm = np.linalg.norm(v, axis=-1, keepdims=True)
    small = norm < 1e-12
    factor = 2.0 * np.arctan2(norm, np.abs(w)) / np.where(small, 1.0, norm)
    result: Array = sign * np.where(small, 2.0, factor) * v
    return result


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Hamilton product of quaternions (..., 4): first b, then a."""
    a = np.asarray(a, dtype=np.float64)
    b = np.asarray(b, dtype=np.float64)
    aw, ax, ay, az = (a[..., i] for i in range(4))
    bw, bx, by, bz = (b[..., i] for i in range(4))
    return _together(
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(quat: ArrayLike) -> Array:
    """Inverse of unit quaternions (..., 4)."""
    result: Array = np.asarray(quat, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def normalize(quat: ArrayLike) -> Array:
    """Quaternions (..., 4) scaled to unit length."""
    quat = np.asarray(quat, dtype=np.float64)
    result: Array = quat / np.linalg.norm(quat, axis=-1, keepdims=True)
    return result


def rotate(quat: ArrayLike, vector: ArrayLike) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    quat = np.asarray(quat, dtype=np.float64)
    vector = np.asarray(vector, dtype=np.float64)
    w, u = quat[..., :1], quat[..., 1:]
    t = 2.0 * cross(u, vector)
    result: Array = vector + w * t + cross(u, t)
    return result


def cross(a: Array, b: Array) -> Array:
    """Cross products of vectors (..., 3): the bits of `np.cross`, which is slower for few."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return _together(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def _together(*columns: Array) -> Array:
    """Columns (...) side by side, (..., n): `np.stack` of the last axis, without its checks."""
    out = np.empty((*np.shape(columns[0]), len(columns)))
    for i, column in enumerate(columns):
        out[..., i] = column
    return out


def to_matrix(quat: ArrayLike) -> Array:
    """Matrices (..., 3, 3) of unit quaternions (..., 4)."""
    quat = np.asarray(quat, dtype=np.float64)
    w, x, y, z = (quat[..., i] for i in range(4))
    nine = _together(
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return nine.reshape(*quat.shape[:-1], 3, 3)


def from_matrix(matrix: ArrayLike) -> Array:
    """Unit quaternions (..., 4), w >= 0, of rotation matrices (..., 3, 3)."""
    m = np.asarray(matrix, dtype=np.float64)
    diagonal = np.diagonal(m, axis1=-2, axis2=-1)
    trace = diagonal.sum(axis=-1)
    # Four times the products of the components; the row of the largest one is well conditioned.
    q = np.empty((*m.shape[:-2], 4, 4))
    q[..., 0, 0] = 1.0 + trace
    skew = [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]]
    for i in range(3):
        q[..., 0, i + 1] = q[..., i + 1, 0] = skew[i]
        q[..., i + 1, i + 1] = 1.0 - trace + 2.0 * diagonal[..., i]
        for j in range(i):
            q[..., i + 1, j + 1] = q[..., j + 1, i + 1] = m[..., i, j] + m[..., j, i]
    best = np.argmax(np.diagonal(q, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(q, best[..., None, None], axis=-2)[..., 0, :]
    row = normalize(row)
    return np.where(row[..., :1] < 0.0, -row, row)


def rotvec_to_matrix(rotvec: ArrayLike) -> Array:
    """Matrices (..., 3, 3) of axis-angle vectors (..., 3)."""
    return to_matrix(exp(rotvec))


def matrix_to_rotvec(matrix: ArrayLike) -> Array:
    """Axis-angle vectors (..., 3), |.| <= pi, of rotation matrices (..., 3, 3)."""
    return log(from_matrix(matrix))


def angles(a: ArrayLike, b: ArrayLike) -> Array:
    """Angles (...) [rad] between rotation vectors (..., 3)."""
    result: Array = np.linalg.norm(log(multiply(conjugate(exp(a)), exp(b))), axis=-1)
    return result


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike) -> Array:
    """Quaternions between a and b (..., 4) at t in [0, 1] (...), along the shortest arc."""
    a = np.asarray(a, dtype=np.float64)
    step = log(multiply(conjugate(a), b))
    return multiply(a, exp(step * np.asarray(t, dtype=np.float64)[..., None]))


def continuous(quaternions: ArrayLike) -> Array:
    """The same rotations (T, ..., 4) without jumps of sign from one frame to the next."""
    q = np.asarray(quaternions, dtype=np.float64)
    dots = np.einsum("t...i,t...i->t...", q[1:], q[:-1])
    signs = np.cumprod(np.where(dots < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([q[:1], signs[..., None] * q[1:]])
