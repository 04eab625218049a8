"""One thread makes frames, and runs requested tasks in between."""

from __future__ import annotations

import threading
import time

import pytest

from halfphysics.viewer.served import Served


class Counting(Served):
    """A stub that shows nothing, and counts its updates."""

    _what = "counting"
    _height = 100

    def __init__(self, due=0.001, failure=None):
        super().__init__("counting", "127.0.0.1", 0)
        self.due, self.rounds, self.who = due, 0, set()
        with self._starting():
            if failure is not None:
                raise failure

    def _due(self):
        return self.due

    def _round(self):
        self._do_tasks()
        self.rounds += 1
        self.who.add(threading.current_thread())


def until(condition):
    end = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)


def test_one_thread_makes_all_rounds_and_does_tasks_in_their_order():
    done = []
    with Counting() as it:
        until(lambda: it.rounds > 3)
        for k in range(100):
            it.do(lambda k=k: done.append((k, threading.current_thread())))
        until(lambda: len(done) == 100)
    assert [k for k, _ in done] == list(range(100))
    assert {who for _, who in done} == it.who == {it._thread}
    assert not it._thread.is_alive()
    rounds = it.rounds
    time.sleep(0.05)
    assert it.rounds == rounds


def test_it_need_not_wait_for_its_time_where_something_is_asked():
    with Counting(due=3600.0) as it:
        begun = threading.Event()
        it.do(begun.set)
        assert begun.wait(30.0)


def test_it_can_be_stopped_from_within_and_while_somebody_waits():
    it = Counting()
    it.do(it.stop)
    it.wait()
    assert it._state == "stopped"
    assert it.url not in it._repr_html_()


def test_what_fails_at_the_start_leaves_no_thread_and_no_server():
    before = set(threading.enumerate())
    with pytest.raises(ZeroDivisionError):
        Counting(failure=ZeroDivisionError())
    until(lambda: set(threading.enumerate()) <= before)


def test_a_failure_is_told_where_nobody_waits(monkeypatch):
    told = []
    monkeypatch.setattr(threading, "excepthook", lambda args: told.append(args.exc_value))
    with Counting() as it:
        it.do(lambda: 1 / 0)
        until(lambda: told)
    assert isinstance(told[0], ZeroDivisionError)
    assert it._failure is told[0]
