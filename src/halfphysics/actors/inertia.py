"""Inertialisation: a new motion starts with the pose and the velocity of the one before.

What is between the two, as an offset x0 of every joint and its rate v0, decays within `seconds` T
by the quintic that ends at rest:

    x(t) = x0 (1 - 10 s^3 + 15 s^4 - 6 s^5) + v0 T (s - 6 s^3 + 8 s^4 - 3 s^5),  s = t / T

Position, velocity and acceleration of the offset are zero at its end. (D. Bollo, Inertialization:
High-Performance Animation Transitions in Gears of War, GDC 2018, has the idea with one more
coefficient, for the acceleration.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class State:
    """A pose on its way: position of the pelvis [m] (3,) and rotations of the joints (55, 4)."""

    root: Array
    quats: Array

    def on(self, before: State) -> State:
        """Where it is after as much time as passed since `before`, at the same velocities."""
        step = rot.log(rot.multiply(rot.conjugate(before.quats), self.quats))
        return State(2.0 * self.root - before.root, rot.multiply(self.quats, rot.exp(step)))


class Inertia:
    """The offset from a new motion to the one before, and how it decays.

    Args:
        old: Two poses of the motion before, at the change and `dt` later (as it would go on).
        new: Of the new motion, at the same times.
        dt: Between the two [s].
        seconds: After which nothing is left of the offset.
    """

    def __init__(
        self, old: tuple[State, State], new: tuple[State, State], dt: float, seconds: float
    ) -> None:
        first, later = (_between(n, o) for n, o in zip(new, old, strict=True))
        self.seconds = seconds
        self._offset, self._rate = first, (later - first) / dt

    def at(self, time: float, new: State) -> State:
        """The new motion's state at `time` [s] after the change, with what is left."""
        if time >= self.seconds:
            return new
        s = time / self.seconds
        cube = s * s * s
        x = 1.0 - cube * (10.0 - 15.0 * s + 6.0 * s * s)
        v = self.seconds * (s - cube * (6.0 - 8.0 * s + 3.0 * s * s))
        left = x * self._offset + v * self._rate
        return State(new.root + left[0], rot.multiply(new.quats, rot.exp(left[1:])))


def _between(new: State, old: State) -> Array:
    """Offset (56, 3) from new to old: of the root [m], and of the joints [rad]."""
    turns = rot.log(rot.multiply(rot.conjugate(new.quats), old.quats))
    return np.concatenate([(old.root - new.root)[None], turns])
