"""Kinematic objects: replayed objects, platforms and doors that move along given trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.scene.items import Object

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class KinematicObject(Object):
    """An object on a given trajectory, as `Scene.add_moving` makes it.

    Its frame has the poses `positions` (K, 3) [m] and `quaternions` (K, 4) in the world, `fps` per
    second from the start of the simulation, interpolated linearly and by SLERP. With `loop` the
    first pose follows the last one, else it stays at the last pose. Its `mass` is infinite.
    `position`, `velocity` and the like are those at the start.
    """

    positions: Array
    quaternions: Array
    fps: float
    loop: bool = False

    __repr__ = short_repr

    def at(self, time: ArrayLike) -> tuple[Array, Array]:
        """Positions (..., 3) and quaternions (..., 4) at times (...) [s], without delays."""
        count = len(self.positions)
        frame = np.asarray(array_of(time), dtype=np.float64) * self.fps
        frame = frame % count if self.loop else np.clip(frame, 0.0, count - 1)
        first = np.minimum(np.floor(frame).astype(np.int64), count - 1)
        share = frame - first
        after = (first + 1) % count if self.loop else np.minimum(first + 1, count - 1)
        a, b = self.positions[first], self.positions[after]
        turned = rot.slerp(self.quaternions[first], self.quaternions[after], share)
        return a + share[..., None] * (b - a), turned


def trajectory(
    what: str, positions: ArrayLike, quaternions: ArrayLike | None
) -> tuple[Array, Array]:
    """Positions (K, 3) and unit quaternions (K, 4), checked; None: no rotation.

    Raises:
        InputError: Other shapes, numbers that are not finite, a quaternion of no length.
    """
    places = _rows(f"{what}: positions", positions, 3, "m")
    if quaternions is None:
        turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(places), 1))
    else:
        turns = _rows(f"{what}: quaternions", quaternions, 4, "w, x, y, z")
        if len(turns) != len(places):
            raise InputError(
                f"{what}: found {len(places)} positions and {len(turns)} quaternions, expected as "
                "many of both"
            )
        length = np.linalg.norm(turns, axis=1)
        if (length < 1e-9).any():
            raise InputError(
                f"{what}: quaternion {int(np.argmin(length))} is of zero length, no rotation; "
                "expected w, x, y, z (no rotation: 1, 0, 0, 0)"
            )
        exact = np.abs(length**2 - 1.0) < 1e-15  # unchanged: files come back the same
        turns = np.where(exact[:, None], turns, turns / length[:, None])
    for array in (places, turns):
        array.setflags(write=False)
    return places, turns


def start_velocity(positions: Array, quaternions: Array, fps: float) -> tuple[Array, Array]:
    """Velocities (3,), (3,) [m/s], [rad/s] in the world at the first pose."""
    if len(positions) < 2:
        return np.zeros(3), np.zeros(3)
    turn = rot.log(rot.multiply(quaternions[1], rot.conjugate(quaternions[0])))
    return (positions[1] - positions[0]) * fps, turn * fps


def _rows(what: str, value: ArrayLike, size: int, unit: str) -> Array:
    try:
        raw = as_array(value)
        ok = raw.dtype.kind in "fiu" and raw.ndim == 2 and raw.shape[1] == size and len(raw) > 0
        array = np.array(raw, dtype=np.float64) if ok else None
    except (TypeError, ValueError):
        array = None
    if array is None:
        shape = f" of shape {np.shape(value)}" if isinstance(value, np.ndarray) else ""
        raise InputError(
            f"{what}: expected an array (K, {size}) of numbers [{unit}], K at least 1, found "
            f"{shown(value)}{shape}"
        )
    if not np.isfinite(array).all():
        row = int(np.argmin(np.isfinite(array).all(axis=1)))
        raise InputError(f"{what}: row {row} is {array[row]}, expected finite numbers")
    return array
