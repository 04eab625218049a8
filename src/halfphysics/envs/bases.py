"""Mobile bases, N at once: velocity commands to the rests of their motors x, y and yaw."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: How far the motors' rests may be ahead of the base [m], [rad]: what blocks it is then pushed with
#: no more than that, and the base does not jump when it is free again.
LEASH = np.array([0.12, 0.12, 0.25])


class Bases:
    """N bases: where they are told to be.

    Attributes:
        told: Rests of x, y [m] and yaw [rad] (N, 3).
    """

    def __init__(self, count: int) -> None:
        self.told = np.zeros((count, 3))

    def start(self, i: int, place: Array, yaw: float) -> dict[str, float]:
        """Base `i` stands at a place (2,) [m]; the values of its joints."""
        self.told[i] = [*place, yaw]
        x, y, yaw = (float(v) for v in self.told[i])
        return {"robot/x": x, "robot/y": y, "robot/yaw": yaw}

    def drive(self, now: Array, velocity: Array, dt: float, active: Flags) -> Array:
        """The rests (N, 3) after `dt` [s] at a velocity.

        Args:
            now: Where the motors are (N, 3).
            velocity: Of x, y [m/s] in the world and yaw [rad/s] (N, 3).
            dt: Length of the frame [s].
            active: Whose rests change (N,).
        """
        told = np.clip(self.told + dt * velocity, now - LEASH, now + LEASH)
        self.told = np.where(active[:, None], told, self.told)
        return self.told


def ahead(speed: Array, yaw: Array) -> tuple[Array, Array]:
    """Velocity (N,), (N,) in the world of a speed (N,) in the direction of yaw (N,)."""
    return speed * np.cos(yaw), speed * np.sin(yaw)


def into(vectors: Array, yaw: Array) -> Array:
    """Vectors (N, 2) of the world in frames turned by yaw (N,)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=1)


def wrapped(angle: Array) -> Array:
    """Angles within half a turn of 0 [rad]."""
    out: Array = (angle + np.pi) % (2.0 * np.pi) - np.pi
    return out
