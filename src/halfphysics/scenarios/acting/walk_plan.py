"""The plan of a walk: its steps, and the positions of pelvis and feet at each phase.

The phase counts steps. Step length follows from speed by the walk ratio, which is the same for most
adults at most speeds (Sekiya and Nagasaki 1998).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError
from halfphysics.motion.easing import ease

Array = NDArray[np.float64]

#: Step length over steps per second [m s].
WALK_RATIO = 0.0064 * 60.0


@dataclass(frozen=True, kw_only=True)
class Kick:
    """A step that swings its foot through a ball.

    Attributes:
        step: Index of the step in the walk, from 0.
        slow: Extra time as a fraction of an ordinary step's (1: twice as long).
    """

    step: int
    slow: float = 0.8


@dataclass(frozen=True, kw_only=True)
class Walk:
    """A straight walk along +x, from standing to standing.

    Attributes:
        distance: Length of the whole walk [m].
        speed: Speed of the pelvis between the first and the last step [m/s].
        start: Start of the walk, (x, y) [m].
        heading: Direction of walking about z [rad], 0 along +x.
        before: Time standing before the first step [s].
        after: Time standing after the last step [s].
        first: The foot that steps first, "left" or "right".
        kick: A kick on the way, or None.
        lift: Height of the soles over the ground at z = 0 [m]: more than the simulator's
            clearance, so that the floor does not disturb the motion.
    """

    distance: float
    speed: float = 1.2
    start: tuple[float, float] = (0.0, 0.0)
    heading: float = 0.0
    before: float = 0.5
    after: float = 0.5
    first: str = "right"
    kick: Kick | None = None
    lift: float = 0.004

    def __post_init__(self) -> None:
        if not 0.2 <= self.speed <= 2.2:
            raise InputError(f"speed: found {self.speed!r}, expected a walk: 0.2 to 2.2 m/s")
        if not self.distance > 0.0:
            raise InputError(f"distance: found {self.distance!r}, expected over 0 m")
        if self.first not in ("left", "right"):
            raise InputError(f"first: found {self.first!r}, expected 'left' or 'right'")
        if self.kick is not None and not 1 <= self.kick.step < self.steps - 2:
            raise InputError(
                f"kick: found step {self.kick.step}, expected 1 to {self.steps - 3} in a walk of "
                f"{self.steps} steps"
            )

    @property
    def steps(self) -> int:
        """Number of steps, the shorter first and last ones included."""
        result: int = max(3, round(self.distance / np.sqrt(WALK_RATIO * self.speed)) + 1)
        return result

    @property
    def stride(self) -> float:
        """Length of an ordinary step [m]."""
        return self.distance / (self.steps - 1)

    def swinging(self, step: int) -> str:
        """The foot that swings in a step."""
        other = "left" if self.first == "right" else "right"
        return self.first if step % 2 == 0 else other

    def travelled(self, phase: ArrayLike) -> Array:
        """Distance of the pelvis along the path at a phase [m]."""
        phase = np.asarray(phase, dtype=np.float64)

        def risen(x: Array) -> Array:  # integral of `ease` from 0
            x1 = np.clip(x, 0.0, 1.0)
            return x1**4 * (2.5 + x1 * (x1 - 3.0)) + np.clip(x - 1.0, 0.0, None)

        n = self.steps
        return self.stride * (risen(phase) - risen(phase - (n - 1.0)))

    def mark(self, step: int) -> float:
        """Position along the path where the foot of a step lands [m]; both feet start at 0."""
        if step < 0:
            return 0.0
        return min(float(self.travelled(step + 1.0)) + 0.5 * self.stride, self.distance)

    def clock(self) -> tuple[Array, Array]:
        """Times [s] and the phases at them, fine enough to interpolate."""
        phase = np.linspace(0.0, self.steps, 400 * self.steps + 1)
        pace = np.full_like(phase, self.stride / self.speed)
        if self.kick is not None:
            x = (phase - self.kick.step + 0.35) / 1.7
            pace *= 1.0 + self.kick.slow * ease(3.0 * x) * ease(3.0 * (1.0 - x))
        ticks = 0.5 * (pace[1:] + pace[:-1]) * np.diff(phase)
        time = self.before + np.concatenate([[0.0], np.cumsum(ticks)])
        time = np.concatenate([[0.0], time, [time[-1] + self.after]])
        return time, np.concatenate([[0.0], phase, [phase[-1]]])
