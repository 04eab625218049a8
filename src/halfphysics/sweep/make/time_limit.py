"""A variant may take so long and no longer."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from halfphysics.errors import InputError

_AGAIN = 1.0  # code that goes on nevertheless is interrupted again after so long [s]


class OutOfTimeError(BaseException):
    """It took too long. No `Exception`: nothing on the way may take it for its own failure."""


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise `OutOfTimeError` inside the block after so long [s] by the clock; None: no limit.

    It is raised between two steps of Python: what runs in native code comes to its end first (the
    physics comes back to Python every tenth of a second, or after the frame that it is at).
    """
    if seconds is None:
        yield
        return
    check_possible()

    inside = True

    def late(*_: object) -> None:
        if inside:
            raise OutOfTimeError

    before = signal.signal(signal.SIGALRM, late)
    # Again and again: Python drops what is raised in a destructor.
    signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
    try:
        try:
            yield
        finally:
            # What comes while the clock is put back must not leave it running.
            inside = False
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def check_possible() -> None:
    """Whether this process can look at the clock while it works.

    Raises:
        InputError: The system has no timers for it, or this is no main thread.
    """
    if not hasattr(signal, "setitimer"):
        raise InputError(
            "a limit of time: expected a system with interval timers (Linux, macOS). Leave out "
            "--limit"
        )
    if threading.current_thread() is not threading.main_thread():
        raise InputError(
            "a limit of time: found a thread beside the main one, expected a process of its own. "
            "Leave out the limit"
        )
