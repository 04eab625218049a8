"""The log of what takes time, under the name "halfphysics" of the logging package.

A step that took over a second is logged at INFO when it is done, a shorter one at DEBUG; so are
details (what a cache had, tolerances). No handler is installed: nothing is printed unless the
program asks for it, as with `logging.basicConfig(level=logging.INFO)`.
"""

from __future__ import annotations

import logging
import time

#: What takes longer is worth knowing [s].
LONG = 1.0


class Stopwatch:
    """Starts when it is made; `done` logs what was done and how long it took.

    Args:
        logger: Of the module: `logging.getLogger(__name__)`.
    """

    def __init__(self, logger: logging.Logger) -> None:
        self._logger, self._start = logger, time.perf_counter()

    def done(self, text: str, *values: object, count: int = 0, unit: str = "frame") -> None:
        """Log a message of logging's own form ("%s"), with the time taken.

        Args:
            text, values: What was done.
            count, unit: Of what so many were done, for "400 frames/s"; 0: nothing to count.
        """
        took = time.perf_counter() - self._start
        level = logging.INFO if took >= LONG else logging.DEBUG
        if not self._logger.isEnabledFor(level):
            return
        speed = f" ({count / max(took, 1e-9):.3g} {unit}s/s)" if count else ""
        self._logger.log(level, f"{text} in %.2f s{speed}", *values, took)
