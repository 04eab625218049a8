"""How one thread wakes another that waits for it or for a time.

A socket, and not a lock: Linux takes a wake-up by a socket as the hand-over that it is, since the
thread that writes soon sleeps, and lets the one that is woken follow it on its processor. One that
is woken by a lock may be put behind a thread of another program, until the next tick of the clock:
of a server on two processors, one of them busy, 2 % of all steps began 1 to 4 ms late.
"""

from __future__ import annotations

import contextlib
import select
import socket
import weakref

#: Wake-ups that are read at once.
_READ = 4096


class Wakeup:
    """Wakes one thread, from any.

    A wake-up that comes while nobody waits is kept: the next `wait` returns at once.
    """

    def __init__(self) -> None:
        self._ears, self._mouth = socket.socketpair()
        for end in (self._ears, self._mouth):
            end.setblocking(False)
        weakref.finalize(self, _close, self._ears, self._mouth)

    def wake(self) -> None:
        """Let `wait` return."""
        with contextlib.suppress(BlockingIOError):  # full of wake-ups: one more changes nothing
            self._mouth.send(b"\0")

    def wait(self, seconds: float) -> None:
        """Return at the next wake-up, or after so long."""
        try:
            select.select([self._ears], [], [], max(seconds, 0.0))
        except ValueError:  # a program with over a thousand open files: to the millisecond
            poll = select.poll()
            poll.register(self._ears, select.POLLIN)
            poll.poll(1000.0 * max(seconds, 0.0))
        with contextlib.suppress(BlockingIOError):  # there is none: the time is over
            while len(self._ears.recv(_READ)) == _READ:
                pass


def _close(*ends: socket.socket) -> None:
    for end in ends:
        end.close()
