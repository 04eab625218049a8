"""When the next frame is due, and how much of real time is kept."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

# Frames that the read-out looks back on.
_WINDOW = 60


class Pace:
    """Frames at a rate, as far as the machine can: what is missed is never caught up.

    A machine too slow plays in slow motion; nothing piles up.

    Args:
        now: A clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._due = -math.inf
        self._done: deque[tuple[float, float]] = deque(maxlen=_WINDOW)

    def wait(self) -> float:
        """Until the next frame is due [s]; 0: it is."""
        return max(self._due - self._now(), 0.0)

    def made(self, period: float) -> None:
        """A frame was begun that stands for `period` [s] of the clock on the wall."""
        now = self._now()
        # A little late (a sleep that was too long) is made up for; a frame late is not.
        begun = now if self._due == -math.inf else max(self._due, now - period)
        self._due = begun + period
        self._done.append((now, period))

    def rest(self) -> None:
        """It stood still: time begins anew with the next frame."""
        self._due = -math.inf
        self._done.clear()

    @property
    def kept(self) -> float | None:
        """Part of real time that was kept lately, 1: all; None: too early to tell."""
        if len(self._done) < _WINDOW // 4:
            return None
        passed = self._done[-1][0] - self._done[0][0]
        meant = sum(period for _, period in list(self._done)[:-1])
        return min(meant / passed, 1.0) if passed > 0.0 else 1.0
