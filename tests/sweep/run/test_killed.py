"""A sweep that is killed, again and again, leaves the same bytes as an undisturbed one.

As a script it kills more often::

    PYTHONPATH=tests python tests/sweep/run/test_killed.py [KILLS] [SEED] [VARIANTS]
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.run.driver import run
from halfphysics.sweep.store.store import Store
from support.processes import group_ends, needs_proc, of_group
from support.sweeps.sweep_case import PLAN, Here, Told, data

pytestmark = pytest.mark.slow


def started(plan, out):
    return subprocess.Popen(
        [sys.executable, "-m", "halfphysics", "sweep", str(plan), "--out", str(out), "--jobs", "2"],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


def undisturbed(plan, out):
    engine = Here(out)
    with Store(out, Plan.load(plan)) as store:
        run(store, engine, Told())
    return data(out)


def workers_of(pid):
    """The workers of a running sweep."""
    return [other for other in of_group(pid) if other != pid]


def progress_of(out):
    """The amount of output, as a number that grows."""
    return len(list(out.glob("work/0*/*.json"))) + 10 * len(list(out.glob("shards/*/*.json")))


def killed(plan, out, kills, chance):
    """Start and kill a sweep so often; the first kill waits for the first output."""
    for _ in range(kills):
        process = started(plan, out)
        before = progress_of(out)
        deadline = time.monotonic() + 120.0
        while progress_of(out) <= before and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, 0.3))
        process.kill()
        process.communicate()
        assert group_ends(process.pid, 30.0), "the workers have ended with their parent"


def ended(plan, out):
    process = started(plan, out)
    err = process.communicate(timeout=600.0)[1].decode()
    assert process.returncode == 0, err


@needs_proc
def test_killed_at_any_moment_it_finishes_with_the_same_bytes(tmp_path):
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    killed(plan, tmp_path / "out", 2, random.Random(0))
    # Its workers too are killed one after the other, and it recovers.
    process = started(plan, tmp_path / "out")
    deadline = time.monotonic() + 120.0
    while len(workers_of(process.pid)) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    for worker in workers_of(process.pid):
        os.kill(worker, signal.SIGKILL)
    err = process.communicate(timeout=600.0)[1].decode()
    assert process.returncode == 0, err
    assert data(tmp_path / "out") == undisturbed(plan, tmp_path / "whole")


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    kills, seed, variants = [*numbers, *(10, 0, 200)[len(numbers) :]]
    with tempfile.TemporaryDirectory() as name:
        plan = Path(name) / "plan.yaml"
        count = -(-variants // 4)
        text = PLAN.replace("[0.5, 1, 2]", f"{{from: 0.5, to: 2, count: {count}}}")
        plan.write_text(text.replace("variants_per_shard: 8", "variants_per_shard: 30"))
        killed(plan, Path(name) / "out", kills, random.Random(seed))
        ended(plan, Path(name) / "out")
        same = data(Path(name) / "out") == undisturbed(plan, Path(name) / "whole")
        print(f"{kills} kills: {'the same bytes' if same else 'OTHER BYTES'}")
        sys.exit(not same)
