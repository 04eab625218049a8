"""A time limit for one variant."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from halfphysics.base.validation import number
from halfphysics.errors import InputError

#: Longest limit [s], three years: the timers of some systems refuse more.
LONGEST = 1e8
_AGAIN = 1.0  # code that continues nevertheless is interrupted again after this time [s]


class OutOfTimeError(BaseException):
    """The time limit has passed. Not an `Exception`, so that no `except Exception` catches it."""


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise `OutOfTimeError` inside the block after `seconds` of wall time [s]; None: no limit.

    It is raised between two steps of Python: a native call ends first (the physics returns to
    Python every tenth of a second, or after the current frame).
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
    # The timer repeats: Python drops an exception raised in a destructor.
    signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
    try:
        try:
            yield
        finally:
            # A signal during the reset of the timer must not leave the timer running.
            inside = False
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def check_limit(seconds: float, name: str) -> None:
    """Check that a timer can be set to a limit [s].

    Raises:
        InputError: It is not above 0 and at most `LONGEST`; the message begins with `name`.
    """
    if number(seconds, name, above=0.0, unit="s") > LONGEST:
        raise InputError(
            f"{name}: found {seconds:g} s, expected at most {LONGEST:g} s, or no limit"
        )


def check_possible() -> None:
    """Check that this process can interrupt itself by a timer.

    Raises:
        InputError: The system has no interval timers, or this is not the main thread.
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
