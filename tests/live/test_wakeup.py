"""Waking a thread."""

from __future__ import annotations

import gc
import select
import threading
import time

import pytest

from halfphysics.live.wakeup import Wakeup


def test_who_waits_is_woken():
    wakeup, woken = Wakeup(), []
    thread = threading.Thread(target=lambda: woken.append(wakeup.wait(60.0)))
    thread.start()
    wakeup.wake()
    thread.join(20.0)
    assert woken == [None]


def test_a_wake_up_is_kept_and_then_used_up():
    """Any number of them lets one `wait` return at once; the next waits for its time."""
    wakeup = Wakeup()
    for _ in range(3000):
        wakeup.wake()
    wakeup.wait(60.0)
    begun = time.perf_counter()
    wakeup.wait(0.02)
    assert time.perf_counter() - begun >= 0.02


def test_a_time_that_is_past_waits_not_at_all():
    Wakeup().wait(-1.0)


def test_it_never_blocks_who_wakes():
    wakeup = Wakeup()
    for _ in range(2_000_000 // 8):  # far more than a socket's buffer holds
        wakeup.wake()


def test_its_sockets_go_with_it():
    wakeup = Wakeup()
    ends = [wakeup._ears, wakeup._mouth]
    assert all(end.fileno() >= 0 for end in ends)
    del wakeup
    gc.collect()
    assert [end.fileno() for end in ends] == [-1, -1]


@pytest.mark.skipif(not hasattr(select, "poll"), reason="no poll here")
def test_a_program_with_over_a_thousand_open_files(monkeypatch):
    """`select` takes no file from number 1024 on."""

    def refused(*_):
        raise ValueError("filedescriptor out of range in select()")

    monkeypatch.setattr(select, "select", refused)
    wakeup, begun = Wakeup(), time.perf_counter()
    wakeup.wait(0.02)
    assert time.perf_counter() - begun >= 0.02
    wakeup.wake()
    wakeup.wait(60.0)
    assert time.perf_counter() - begun < 30.0
