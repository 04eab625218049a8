"""A thread that is soon given a processor when it wakes, on Linux.

A thread that wakes on a busy machine waits until the one that runs has used up its slice, 3 to 4 ms
by default: a third of a frame. Since Linux 6.12 a thread may ask for shorter slices of its own
(sched_setattr(2), `sched_runtime`; no privilege is needed). It then gets as much time as before,
in more and shorter turns, the first of them almost at once.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys

#: Length of a turn, the shortest that Linux takes [s].
SLICE = 1e-4
#: Numbers of the system call, by machine: C libraries have had a name for it only since 2024.
_CALLS = {"x86_64": 314, "aarch64": 274}
#: struct sched_attr: size, policy, flags, nice, priority, runtime [ns], deadline, period, and two
#: bounds of utilization.
_ATTRIBUTES = struct.Struct("<IIQiIQQQII")


def short_slices() -> bool:
    """Ask for short slices for the calling thread and the threads that it starts from now on.

    Returns:
        Whether the system took it; kernels before 6.12 take it and pay no attention. Elsewhere than
        on Linux nothing happens.
    """
    number = _CALLS.get(platform.machine())
    if sys.platform != "linux" or number is None:
        return False
    if os.sched_getscheduler(0) != os.SCHED_OTHER:  # somebody has chosen what is better
        return False
    nice, runtime = os.getpriority(os.PRIO_PROCESS, 0), round(1e9 * SLICE)
    asked = _ATTRIBUTES.pack(_ATTRIBUTES.size, os.SCHED_OTHER, 0, nice, 0, runtime, 0, 0, 0, 0)
    try:
        return int(ctypes.CDLL(None).syscall(number, 0, asked, 0)) == 0
    except (OSError, AttributeError):  # another C library
        return False
