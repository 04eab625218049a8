"""The time when the next frame is due, and the fraction of real time achieved."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

# Number of last frames that `kept` covers.
_WINDOW = 60


class Pace:
    """Paces frames at a rate as far as the machine can; missed time is never caught up.

    A slow machine plays in slow motion; no delay accumulates.

    Args:
        now: A clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._due = -math.inf
        self._done: deque[tuple[float, float]] = deque(maxlen=_WINDOW)

    def wait(self) -> float:
        """Time until the next frame is due [s]; 0: it is due."""
        return max(self._due - self._now(), 0.0)

    def made(self, period: float) -> None:
        """Record the start of a frame that covers `period` [s] of wall-clock time."""
        now = self._now()
        # A delay below one frame (a long sleep) is made up for; a longer one is not.
        begun = now if self._due == -math.inf else max(self._due, now - period)
        self._due = begun + period
        self._done.append((now, period))

    def rest(self) -> None:
        """Playing was paused: timing restarts with the next frame."""
        self._due = -math.inf
        self._done.clear()

    @property
    def kept(self) -> float | None:
        """Fraction of real time achieved over the last frames, at most 1; None: too few frames."""
        if len(self._done) < _WINDOW // 4:
            return None
        passed = self._done[-1][0] - self._done[0][0]
        meant = sum(period for _, period in list(self._done)[:-1])
        return min(meant / passed, 1.0) if passed > 0.0 else 1.0
