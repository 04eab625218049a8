"""The usual time between two poses of a sender, from when they arrived.

    interval = sum(gap) / sum(periods of the gap),

so what the network does to single poses cancels out over the gaps. A gap is one period; of lost
poses some more, and none of poses that were held up and come together. The period is the interval
before; of few gaps, it is their median, or their mean where most poses come together.
"""

from __future__ import annotations

import statistics
from collections import deque

#: Gaps that count, and up to how many the period is their median. That number is even: of poses
#: that come in pairs, the median is the mean of the two gaps.
_COUNTED, _FEW = 64, 8
#: The sender has another rate if so many gaps in a row are longer or shorter by this factor: jitter
#: makes no more than every other gap so, and lost poses are rare. Only these gaps count from then.
_ROW, _CHANGED = 4, 1.6
#: Share of a period by which the network makes one gap longer, and the next one shorter.
_JITTER = 0.75


class Interval:
    """The usual time between two poses of one sender.

    Attributes:
        seconds: The interval [s]; 0: unknown.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._gaps: deque[float] = deque(maxlen=_COUNTED)
        self._longer = self._shorter = 0  # such gaps in a row

    def clear(self) -> None:
        """The sender paused, or is another."""
        self.seconds = 0.0
        self._gaps.clear()
        self._longer = self._shorter = 0

    def add(self, gap: float) -> None:
        """A pose arrived, so long after the one before it [s]."""
        self._gaps.append(gap)
        self._longer = self._longer + 1 if gap > self.seconds * _CHANGED else 0
        self._shorter = self._shorter + 1 if gap < self.seconds / _CHANGED else 0
        if max(self._longer, self._shorter) >= _ROW:
            while len(self._gaps) > _ROW:
                self._gaps.popleft()
            self._longer = self._shorter = 0
        period = self._of_few() if len(self._gaps) <= _FEW else self.seconds
        periods = sum(_periods(gap, period) for gap in self._gaps)
        self.seconds = sum(self._gaps) / periods if periods > 0 else period

    def _of_few(self) -> float:
        median, mean = statistics.median(self._gaps), statistics.fmean(self._gaps)
        return median if median > (1.0 - _JITTER) * mean else mean


def _periods(gap: float, period: float) -> int:
    if period <= 0.0:
        return 0
    return 1 if abs(gap / period - 1.0) < _JITTER else round(gap / period)
