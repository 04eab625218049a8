"""Worker processes: a death costs one item, memory is bounded, no process is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from halfphysics.base import workers
from halfphysics.base.workers import DIED, FULL, Death, Pool, StartError
from support.paths import TESTS
from support.workers_case import MIB, act

linux = pytest.mark.skipif(sys.platform != "linux", reason="tells what processes hold and refuses")


def answers(pool, count):
    found = []
    while len(found) < count:
        found += pool.wait()
    return dict(found)


def alive(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def gone(pids, seconds=10.0):
    """Waits until none of these processes is left."""
    deadline = time.monotonic() + seconds
    while any(map(alive, pids)) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not any(map(alive, pids))


def test_a_death_costs_one_item_and_the_same_processes_go_on():
    before = dict(os.environ)
    with Pool(act, 2) as pool:
        for order in ("a", "die 1", "b", "c", "die 2", "threads"):
            pool.submit(order)
        found = answers(pool, 6)
        assert found.pop("die 1") == found.pop("die 2") == Death(DIED)
        assert found.pop("threads") == os.environ.get("OMP_NUM_THREADS", "1")
        assert len(found) == 3
        assert pool.wait() == [], "nothing is under way"
        pool.submit("again")
        pids = set(answers(pool, 1).values()) | set(found.values())
    assert os.getpid() not in pids
    assert gone(pids)
    assert dict(os.environ) == before


def test_alone_means_nothing_before_and_nothing_after():
    with Pool(act, 1) as pool:
        pool.submit("a")
        pool.submit("b", alone=True)
        pool.submit("c", alone=True)
        pool.submit("d")
        found = answers(pool, 4)
        assert len(set(found.values())) == 4


@linux
def test_memory_is_bounded():
    with Pool(act, 1, memory=200 * MIB) as pool:
        for order in ("a", "take 100", "b", "hold 170", "c", "take 250", "d"):
            pool.submit(order)
        found = answers(pool, 7)
    assert found["take 100"] == 100 * MIB
    assert found["a"] == found["b"], "what was given back is no reason"
    assert found["b"] == found["hold 170"]
    assert found["c"] != found["b"], "it held more than it should between two items"
    assert found["take 250"] == Death(FULL)
    assert found["d"] != found["c"], "it ran into its limit"


def test_processes_that_never_begin_are_an_error(monkeypatch, capfd):
    with Pool(os.fspath, 2) as pool:
        # As in a script without a guard: the process ends before it reads its first order.
        monkeypatch.setattr(workers, "_serve", sys.exit)
        pool.submit("a")
        with pytest.raises(StartError, match="__main__"):
            answers(pool, 1)
    capfd.readouterr()


def test_who_dies_with_nothing_to_do_is_replaced():
    with Pool(act, 1) as pool:
        pool.submit("a")
        (pid,) = answers(pool, 1).values()
        os.kill(pid, signal.SIGKILL)
        assert gone([pid])
        pool.submit("b")
        assert answers(pool, 1)["b"] != pid


_SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
from support.workers_case import act
from halfphysics.base.workers import Pool
if __name__ == "__main__":
    with Pool(act, 2) as pool:
        for i in range(500):
            pool.submit("log {log}")
        while pool.wait():
            pass
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="counts processes in /proc")
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_nobody_is_left_behind(tmp_path, sign):
    log, script = tmp_path / "log.txt", tmp_path / "script.py"
    script.write_text(_SCRIPT.format(tests=str(TESTS), log=log))
    process = subprocess.Popen(
        [sys.executable, str(script)], start_new_session=True, stderr=subprocess.PIPE
    )
    deadline = time.monotonic() + 60.0
    while (not log.exists() or len(log.read_text().split()) < 5) and time.monotonic() < deadline:
        time.sleep(0.02)
    if sign == signal.SIGINT:
        os.killpg(process.pid, sign)  # as a terminal sends it
    else:
        process.send_signal(sign)
    errors = process.communicate(timeout=10.0)[1].decode()
    pids = set(map(int, log.read_text().split()))
    assert pids
    assert gone(pids)
    if sign == signal.SIGINT:
        assert errors.count("Traceback") == 1, "the parent's alone"
