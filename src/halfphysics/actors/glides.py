"""Numbers that change without a jerk: to a goal in a given time, or after a goal that moves."""

from __future__ import annotations

import math


class Glide:
    """A number on its way to a goal: the quintic from its value and speed to rest there.

    Speed is continuous whenever the goal changes; acceleration is zero at both ends.
    """

    def __init__(self, value: float = 0.0) -> None:
        self.value, self.speed = value, 0.0
        self._from, self._rate = value, 0.0
        self.goal, self._seconds, self._time = value, 1.0, 1.0

    @property
    def there(self) -> bool:
        """Whether it is at its goal."""
        return self._time >= self._seconds

    def to(self, goal: float, seconds: float) -> None:
        """Be at a goal after some time [s] from now on; what is on its way there goes on."""
        if goal == self.goal:
            return
        self._from, self._rate = self.value, self.speed
        self.goal, self._seconds, self._time = goal, seconds, 0.0

    def put(self, value: float, dt: float) -> None:
        """Be at a value, `dt` [s] after the last one: from there a next goal goes on."""
        self.value, self.speed = value, (value - self.value) / dt
        self.goal, self._time = math.nan, self._seconds

    def advance(self, dt: float) -> float:
        """The value `dt` [s] later."""
        self._time = min(self._time + dt, self._seconds)
        if self._time >= self._seconds:
            self.value, self.speed = self.goal, 0.0
            return self.value
        T, s = self._seconds, self._time / self._seconds
        q, way = s * s, self.goal - self._from
        e, de = s * q * (10.0 - 15.0 * s + 6.0 * q), 30.0 * q * (1.0 - s) * (1.0 - s)
        h = s - s * q * (6.0 - 8.0 * s + 3.0 * q)
        dh = 1.0 - q * (18.0 - 32.0 * s + 15.0 * q)
        self.value = self._from + way * e + self._rate * T * h
        self.speed = way * de / T + self._rate * dh
        return self.value


class Spring:
    """A number that follows a goal that moves, critically damped.

    Args:
        time: After twice this it has come most of the way (91 %) [s].
        value: At the begin.
    """

    def __init__(self, time: float, value: float = 0.0) -> None:
        self._omega = 2.0 / time
        self.value, self.speed = value, 0.0

    def advance(self, goal: float, dt: float) -> float:
        """The value `dt` [s] later; exact for a goal at rest."""
        w = self._omega
        away = self.value - goal
        k = self.speed + away * w
        decay = math.exp(-w * dt)
        self.value = goal + (away + k * dt) * decay
        self.speed = (self.speed - k * w * dt) * decay
        return self.value
