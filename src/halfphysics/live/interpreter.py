"""Python set for short answers, for a process that does nothing but serve."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import sys
from collections.abc import Iterator

#: How long a thread may keep the interpreter while another waits for it [s]. Python's 5 ms would
#: be half of a frame; what a step does after its frame was handed over takes some 0.1 ms.
SWITCH = 0.0001
#: Parameters of glibc's mallopt, M_TRIM_THRESHOLD and M_MMAP_THRESHOLD [bytes]. A step needs less;
#: with the 128 KiB that glibc begins with, it would get its memory anew at every step.
_GIVEN_BACK = {-1: 4 * 2**20, -3: 2**20}


def steady_memory() -> bool:
    """Let what is freed go back to the system; for good, in this process.

    glibc raises its bound of what is given back with the largest block that was ever freed, here to
    tens of megabytes from building the world; until then memory would creep up for many minutes.

    Returns:
        Whether the allocator does so; elsewhere than with glibc it is left as it is.
    """
    if sys.platform != "linux":
        return False
    try:
        allocator = ctypes.CDLL(None)
        return all(allocator.mallopt(*item) == 1 for item in _GIVEN_BACK.items())
    except (OSError, AttributeError):  # another C library
        return False


@contextlib.contextmanager
def quick_answers() -> Iterator[None]:
    """Within it threads take turns often, and the collector looks at new objects only.

    What was made before is not collected again: a collection of everything takes 50 ms with the
    packages that are loaded. Whoever has frozen objects of their own keeps them so, with ours.
    """
    interval, thresholds = sys.getswitchinterval(), gc.get_threshold()
    frozen = gc.get_freeze_count() > 0  # Python thaws all or nothing
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 1000)
    sys.setswitchinterval(SWITCH)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        gc.set_threshold(*thresholds)
        if not frozen:
            gc.unfreeze()
