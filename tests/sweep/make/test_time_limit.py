"""A variant over the time limit ends, fails with that cause, and leaves no partial files."""

from __future__ import annotations

import json
import signal
import threading
import time

import pytest

from halfphysics.cli import MISTAKE, main
from halfphysics.cli import sweep as command
from halfphysics.errors import InputError
from halfphysics.sweep.make.making import Sample
from halfphysics.sweep.make.time_limit import LONGEST, OutOfTimeError, time_limit
from halfphysics.sweep.run.driver import run
from halfphysics.sweep.run.work import Task, do, opened
from support.sweeps.sweep_case import Here, begun, data, planned

#: The first takes about a tenth of the second's time.
LONG = """
inputs:
  - scenarios: [kick_ball, lift_suitcase]
factors: {scenario.fps: [10]}
outputs: {batch: 1}
"""


def test_it_ends_and_the_clock_is_put_back():
    before = signal.getsignal(signal.SIGALRM)
    start = time.perf_counter()

    def work():
        with time_limit(0.05):
            while time.perf_counter() < start + 20.0:
                sum(range(1000))

    with pytest.raises(OutOfTimeError):
        work()
    assert time.perf_counter() - start < 10.0
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0
    with time_limit(50.0):
        pass
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0
    with time_limit(None):
        assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_what_is_lost_in_a_destructor_is_raised_again():
    class Slow:
        def __del__(self):
            while time.perf_counter() < start + 0.3:
                sum(range(1000))

    def work():
        with time_limit(0.05):
            Slow()
            while time.perf_counter() < start + 20.0:
                sum(range(1000))

    start = time.perf_counter()
    with pytest.raises(OutOfTimeError):
        work()
    assert time.perf_counter() - start < 10.0


def test_an_alarm_while_the_clock_is_put_back_leaves_none_running(monkeypatch):
    setitimer = signal.setitimer

    def late(which, seconds, *again):
        if seconds == 0.0:
            signal.raise_signal(signal.SIGALRM)
        return setitimer(which, seconds, *again)

    before = signal.getsignal(signal.SIGALRM)
    monkeypatch.setattr(signal, "setitimer", late)
    with time_limit(50.0):
        pass
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0
    assert signal.getsignal(signal.SIGALRM) is before


def test_a_thread_cannot_have_one():
    found = []

    def work():
        try:
            with time_limit(1.0):
                found.append("a limit")
        except InputError as error:
            found.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    (said,) = found
    assert "expected a process of its own" in said


def test_what_was_cut_off_leaves_nothing_behind(tmp_path):
    begun(tmp_path / "out", planned(tmp_path, LONG))
    _, maker = opened(str(tmp_path / "out"))
    whole = [maker.sample(number) for number in (0, 1)]
    assert all(isinstance(one, Sample) for one in whole)
    for share in (0.001, 0.05, 0.1, 0.2, 0.3):
        cut = maker.sample(1, limit=share)
        if isinstance(cut, dict):
            assert cut["cause"] == f"it took longer than {share:g} s (--limit)"
            assert cut["input"] == "lift_suitcase"
        again = [maker.sample(number, limit=600.0) for number in (1, 0)]
        assert [one.files for one in again] == [one.files for one in whole[::-1]]


def test_a_task_hands_it_on(tmp_path):
    begun(tmp_path / "out", planned(tmp_path, LONG))
    done = do(str(tmp_path / "out"), Task("batches", 0, 1, limit=1e-4))
    assert (done.kept, done.causes) == (0, ("it took longer than 0.0001 s (--limit)",))


def test_the_command_lists_them_and_tries_them_again(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(command.Command, "_engine", lambda self, folder: Here(folder))
    planned(tmp_path, LONG)
    arguments = ["sweep", str(tmp_path / "plan.yaml")]
    assert main([*arguments, "--out", str(tmp_path / "whole")]) == 0
    out = [*arguments, "--out", str(tmp_path / "cut")]
    assert main([*out, "--limit", "1e-4"]) == MISTAKE  # only failures
    assert "2 failed" in capsys.readouterr().out
    lines = (tmp_path / "cut/failures.jsonl").read_text().splitlines()
    assert {json.loads(line)["cause"] for line in lines} == {
        "it took longer than 0.0001 s (--limit)"
    }
    assert main([*out, "--retry-failed"]) == 0
    assert data(tmp_path / "cut") == data(tmp_path / "whole")
    assert main([*out, "--limit", "0"]) == MISTAKE
    assert "--limit: expected a number above 0 [s], found 0" in capsys.readouterr().err
    assert main([*out, "--limit", "1e20"]) == MISTAKE
    assert "--limit: found 1e+20 s, expected at most 1e+08 s" in capsys.readouterr().err


def test_a_timer_can_be_set_to_the_longest():
    with time_limit(LONGEST):
        pass
    for seconds in (1.1 * LONGEST, 1e300, float("inf"), float("nan"), 0.0):
        with pytest.raises(InputError, match="limit: "):
            run(None, None, None, limit=seconds)
