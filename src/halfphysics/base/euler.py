"""Angles about the axes, in any order, from and to unit quaternions (wxyz)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]

# Nearer than this to gimbal lock (cosine of the middle angle) only the sum or the difference of
# the outer angles means anything: the first one is kept as it was in the frame before.
_LOCKED = 1e-10
# Angles that change by no more than this times the turn itself, or this much [rad], are smooth.
_SMOOTH, _STILL = 1.5, 1e-3


def from_angles(axes: Sequence[int], angles: Array) -> Array:
    """Unit quaternions (..., 4): the product of turns about `axes` (0 x, 1 y, 2 z), in order.

    Args:
        axes: n of them, any order and number.
        angles: (..., n) [rad].
    """
    total = np.zeros((*angles.shape[:-1], 4))
    total[..., 0] = 1.0
    for k, axis in enumerate(axes):
        vector = np.zeros((*angles.shape[:-1], 3))
        vector[..., axis] = angles[..., k]
        total = rot.multiply(total, rot.exp(vector)) if k else rot.exp(vector)
    return total


def to_angles(axes: Sequence[int], quaternions: Array) -> Array:
    """Angles (T, J, 3) [rad] about three different `axes`, of quaternions (T, J, 4), T >= 1.

    Continuous from frame to frame (no jumps by a whole turn or between the two triples that give
    one rotation), and exact as rotations at gimbal lock: the last two angles are taken from what
    is left when the first is undone, whatever it is.
    """
    i, j, k = axes
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    matrix = rot.to_matrix(quaternions)
    # R = Ri(a) Rj(b) Rk(c): its middle rows in column k are -+sin(a) cos(b) and cos(a) cos(b).
    side, along = -sign * matrix[..., j, k], matrix[..., k, k]
    first = np.arctan2(side, along)
    angles = _rest(axes, sign, quaternions, first)
    other = np.stack([first + np.pi, np.pi - angles[..., 1], angles[..., 2] + np.pi], axis=-1)
    locked = np.hypot(side, along) < _LOCKED
    out = np.empty_like(angles)
    # A clip that starts locked starts with the angle that it comes out with.
    free = np.argmin(locked, axis=0)
    before = np.zeros_like(angles[0])
    before[:, 0] = np.take_along_axis(first, free[None], axis=0)[0]
    for t in range(len(angles)):
        choices = np.stack([angles[t], other[t]])
        if locked[t].any():
            kept = _rest(axes, sign, quaternions[t], before[:, 0])
            choices = np.where(locked[t][None, :, None], kept, choices)
        choices += 2.0 * np.pi * np.rint((before - choices) / (2.0 * np.pi))
        far = np.abs(choices - before).sum(axis=-1)
        pick = (far[1] < far[0] - 1e-12) & (t > 0)
        before = out[t] = np.where(pick[:, None], choices[1], choices[0])
    return out


def smoothest(
    quaternions: Array, usual: tuple[int, int, int]
) -> tuple[list[tuple[int, int, int]], Array]:
    """For each joint the order of axes whose angles change least from frame to frame.

    Near gimbal lock small turns are large changes of angles, and every order has its lock
    elsewhere.

    Args:
        quaternions: (T, J, 4), T >= 1.
        usual: The order to take where it is as good as any.

    Returns:
        J orders, and angles (T, J, 3) [rad].
    """
    angles = to_angles(usual, quaternions)
    orders = [usual] * quaternions.shape[1]
    turn = rot.multiply(rot.conjugate(quaternions[:-1]), quaternions[1:])
    least = np.linalg.norm(rot.log(turn), axis=-1).max(axis=0, initial=0.0)
    steps = np.abs(np.diff(angles, axis=0)).max(axis=(0, 2), initial=0.0)
    poor = np.flatnonzero(steps > _SMOOTH * least + _STILL)
    for axes in permutations(range(3)):
        if axes == usual or not len(poor):
            continue
        other = to_angles(axes, quaternions[:, poor])
        change = np.abs(np.diff(other, axis=0)).max(axis=(0, 2), initial=0.0)
        for place, joint in enumerate(poor.tolist()):
            if change[place] < steps[joint]:
                steps[joint], angles[:, joint] = change[place], other[:, place]
                orders[joint] = (axes[0], axes[1], axes[2])
    return orders, angles


def _rest(axes: Sequence[int], sign: float, quaternions: Array, first: Array) -> Array:
    """The three angles (..., 3) with the first one given."""
    i, j, k = axes
    vector = np.zeros((*first.shape, 3))
    vector[..., i] = -first
    # Rj(b) Rk(c): row j is free of b, column k is free of c.
    left = rot.to_matrix(rot.multiply(rot.exp(vector), quaternions))
    second = np.arctan2(sign * left[..., i, k], left[..., k, k])
    third = np.arctan2(sign * left[..., j, i], left[..., j, j])
    return np.stack([first, second, third], axis=-1)
