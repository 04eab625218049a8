"""Python set for short answers, for a process that does nothing but serve."""

from __future__ import annotations

import contextlib
import gc
import sys
from collections.abc import Iterator

#: How long a thread may keep the interpreter while another waits for it [s]. Python's 5 ms would
#: be half of a frame.
SWITCH = 0.0005


@contextlib.contextmanager
def quick_answers() -> Iterator[None]:
    """Within it threads take turns often, and the collector looks at new objects only.

    What was made before is not collected again: a collection of everything takes 50 ms with the
    packages that are loaded.
    """
    interval, thresholds = sys.getswitchinterval(), gc.get_threshold()
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 1000)
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        gc.set_threshold(*thresholds)
        gc.unfreeze()
