"""Short slices of a thread."""

from __future__ import annotations

import os
import platform
import sys
import threading

import pytest

from halfphysics.live.scheduling import short_slices


def test_the_thread_goes_on_as_it_was():
    """Its policy and its niceness stay; another thread has none of it."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    said = []
    thread = threading.Thread(target=lambda: said.append((short_slices(), _policy())))
    thread.start()
    thread.join()
    (taken, policy) = said[0]
    assert taken == (sys.platform == "linux" and platform.machine() in ("x86_64", "aarch64"))
    assert policy == _policy()
    assert os.getpriority(os.PRIO_PROCESS, 0) == before


def test_unknown_machines_are_left_alone(monkeypatch):
    monkeypatch.setattr(platform, "machine", lambda: "riscv64")
    assert short_slices() is False


@pytest.mark.skipif(sys.platform != "linux", reason="policies of Linux")
def test_a_chosen_policy_stays(monkeypatch):
    monkeypatch.setattr(os, "sched_getscheduler", lambda _: os.SCHED_FIFO)
    assert short_slices() is False


def _policy():
    return os.sched_getscheduler(0) if sys.platform == "linux" else None
