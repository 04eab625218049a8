"""When the next step is due: a fixed clock whose phase follows the poses.

Steps are `dt` apart. A step may begin up to half of that before its time if all poses that are
expected are there, and waits for them up to half of that after it. Its phase moves by a share of
the difference, so that steps come to lie where poses arrive: a pose is stepped at once. The share
is bounded, so the clock runs at most 5 % faster or slower than the wall's. Poses that come faster
than that have no phase to follow: there is always one, and the clock keeps its own. The first pose
after a pause is stepped at once, wherever it lies, and the clock takes its phase. Missed time is
not caught up: the simulation falls behind rather than into a backlog.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

#: Share of `dt` by which a step may be early or late, of a difference that moves the phase, and of
#: `dt` by which it moves it at most.
WINDOW, GAIN, MOST = 0.5, 0.2, 0.05
#: A pause of the poses, after which the clock takes the phase of the next one [s]. It gains a step
#: by that at most, so that whoever pauses on purpose speeds it up by less than `MOST`.
PAUSE = 0.5


def shortest(dt: float) -> float:
    """The shortest interval of poses [s] whose phase steps of `dt` can follow."""
    return (1.0 - MOST) * dt


class Clock:
    """The times of steps.

    Args:
        dt: Time between two steps [s].
        now: A clock [s].

    Attributes:
        missed: Steps left out, since the machine was late by more than one.
        early: Time by which the newest step began before it was due [s]; negative: after.
    """

    def __init__(self, dt: float, now: Callable[[], float] = time.perf_counter) -> None:
        self.dt, self._now = dt, now
        self._due = self._led = -math.inf  # when the last step began that poses gave the time of
        self.missed = 0
        self.early = 0.0

    @property
    def latest(self) -> float:
        """Until when the next step waits for poses, by the clock [s]."""
        return self._due + WINDOW * self.dt

    def wait(self, fresh: bool, expecting: bool) -> float:
        """Time until the step may begin [s]; 0: now.

        Args:
            fresh: All poses that are expected are there.
            expecting: Some pose is expected before `latest`.
        """
        now = self._now()
        if fresh and now - self._led > PAUSE:
            return 0.0
        shift = -WINDOW if fresh else WINDOW if expecting else 0.0
        return max(self._due + shift * self.dt - now, 0.0)

    def begin(self, fresh: bool) -> None:
        """A step begins now. `fresh`: since the poses are there."""
        now = self._now()
        self.early = 0.0
        paused = now - self._led > PAUSE
        if fresh:
            self._led = now
            if paused and now < self._due:
                self._due = now + self.dt
                return
        if self._due == -math.inf or now - self._due > 1.5 * self.dt:
            if self._due > -math.inf:
                self.missed += int((now - self._due) / self.dt)
            self._due = now + self.dt
            return
        self.early = self._due - now
        most = MOST * self.dt
        shift = min(max(GAIN * (now - self._due), -most), most) if fresh else 0.0
        self._due += self.dt + shift
