"""How long poses take, from their arrival to the end of their step."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from halfphysics.live.incoming import Outgoing

#: Number of last poses that the figures are of: ten seconds of two people at 90 Hz.
_LAST = 1800


class Latency:
    """A listener that keeps the latencies of the last poses."""

    def __init__(self) -> None:
        self._seconds: deque[float] = deque(maxlen=_LAST)
        self._seen: dict[str, float] = {}

    def add(self, frame: Outgoing) -> None:
        """Note the poses that this frame has stepped for the first time."""
        for name, stamp in frame.stamps.items():
            if self._seen.get(name) != stamp.received:
                self._seen[name] = stamp.received
                self._seconds.append(stamp.stepped - stamp.received)

    def percentiles(self, *percents: float) -> tuple[float, ...] | None:
        """Percentiles [s] of the last poses; None: there were none."""
        seconds = list(self._seconds)
        if not seconds:
            return None
        return tuple(float(p) for p in np.percentile(seconds, percents))
