"""`--engine ray`: a dead process costs its own task, and all else is the same."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import tempfile
import threading
import time
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from halfphysics.base.workers import DIED, FULL, THREADS, Death
from halfphysics.errors import InputError, MissingDependencyError
from halfphysics.sweep.run import ray_engine
from halfphysics.sweep.run.driver import run
from halfphysics.sweep.run.local import GIB, LocalEngine
from halfphysics.sweep.run.ray_engine import LOST, ClusterError, RayEngine
from halfphysics.sweep.run.work import Done, Task, opened
from halfphysics.sweep.store.store import Store
from support.sweeps import sweep_case
from support.sweeps.sweep_case import PLAN, Told, data, deadly, planned

pytestmark = pytest.mark.slow

try:
    import ray
except ImportError:
    ray = None

needs_ray = pytest.mark.skipif(ray is None, reason="ray is not installed")


def task(first, kind="batches"):
    return Task(kind, 0, first, 1)


def ended(engine, tasks):
    """Outcomes of tasks, by task."""
    for one in tasks:
        engine.submit(one)
    found = {}
    while len(found) < len(tasks):
        answers = engine.wait()
        assert answers
        found.update(answers)
    assert engine.wait() == []
    return found


@needs_ray
def test_tasks_end_as_they_do_in_local_processes(tmp_path, capfd, monkeypatch):
    """Deaths, lack of memory, stops, alone or not: one Ray serves all of it."""

    def act(folder, task):
        threads = {os.environ[name] for name in THREADS}
        Path(folder, f"{os.getpid()}-{time.monotonic_ns()}").write_text(str(threads))
        if task.kind == "variants":
            return Done(float(os.getpid()))
        if task.first == 2:
            os.kill(os.getpid(), signal.SIGKILL)
        if task.first == 3:
            raise MemoryError
        if task.first == 4:
            print("why it went wrong", file=sys.stderr)
            return Done(0.0, stop="the disk is full")
        return Done(float(os.getpid()), kept=task.first)

    before = signal.getsignal(signal.SIGTERM)
    scratch = tempfile.mkdtemp(dir="/tmp")
    with monkeypatch.context() as patch:
        patch.setattr(tempfile, "tempdir", scratch)
        engine = RayEngine(tmp_path, 2, 2.0, address="local", function=act)
    try:
        assert engine.slots == 2
        found = ended(engine, [task(i) for i in range(8)])
        assert found[task(2)] == Death(DIED)
        assert found[task(3)] == Death(FULL)
        assert found[task(4)].stop.endswith(": the disk is full")
        assert [found[task(i)].kept for i in (0, 1, 5, 6, 7)] == [0, 1, 5, 6, 7]
        shared = {found[task(i)].seconds for i in (0, 1, 5, 6, 7)}
        assert len(shared) < 5  # processes live on, and keep what they have loaded
        alone = ended(engine, [task(i, "variants") for i in range(2)])
        pids = {done.seconds for done in alone.values()}
        assert len(pids) == 2
        assert not pids & shared
        assert {path.read_text() for path in tmp_path.iterdir()} == {"{'1'}"}
    finally:
        engine.close()
    assert not ray.is_initialized()
    Path(scratch).rmdir()  # the folder is empty
    assert signal.getsignal(signal.SIGTERM) is before
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err == "why it went wrong\n"


class FakeRay:
    """A foreign cluster, whose tasks end as instructed."""

    class exceptions:
        NodeDiedError = type("NodeDiedError", (Exception,), {})
        WorkerCrashedError = type("WorkerCrashedError", (Exception,), {})
        OutOfMemoryError = type("OutOfMemoryError", (Exception,), {})

    def __init__(self):
        self.cores, self.given, self.cancelled = 4, [], []

    def is_initialized(self):
        return True

    def cluster_resources(self):
        return {"CPU": float(self.cores)} if self.cores else {}

    def remote(self, **options):
        assert options["num_cpus"] == 1
        assert options["max_retries"] == 0
        return lambda function: SimpleNamespace(remote=partial(self._give, function))

    def _give(self, function, *order):
        reference = _Reference(function, order)
        self.given.append(reference)
        return reference

    def cancel(self, reference, *, force):
        assert force
        self.cancelled.append(reference)


class _Reference:
    def __init__(self, function, order):
        self.function, self.order, self._future = function, order, Future()

    def future(self):
        return self._future

    def end(self, error=None):
        """By an exception, or by the function's answer."""
        if error is None:
            self._future.set_result(self.function(*self.order))
        else:
            self._future.set_exception(error)


@pytest.fixture
def fake(monkeypatch):
    found = FakeRay()
    monkeypatch.setitem(sys.modules, "ray", found)
    return found


def engine_of(folder, jobs=None):
    return RayEngine(folder, jobs, function=lambda folder, task: Done(0.0, kept=task.first))


def test_a_lost_machine_is_no_fault_of_its_task(tmp_path, fake):
    engine = engine_of(tmp_path)
    engine.submit(task(3))
    fake.given[0].end(fake.exceptions.NodeDiedError())
    engine.submit(task(4))
    fake.given[1].end()
    assert engine.wait() == [(task(4), Done(0.0, kept=4))]
    assert len(fake.given) == 3  # it was handed over again
    fake.given[2].end()
    assert engine.wait() == [(task(3), Done(0.0, kept=3))]


def test_a_task_that_takes_machine_after_machine_down_is_a_death(tmp_path, fake):
    engine = engine_of(tmp_path)
    engine.submit(task(3))
    remote = fake.remote

    class Doomed(_Reference):
        def __init__(self, *order):
            super().__init__(*order)
            self.end(fake.exceptions.NodeDiedError())

    fake._give = lambda function, *order: (
        fake.given.append(Doomed(function, order)) or fake.given[-1]
    )
    engine._remote = remote(num_cpus=1, max_retries=0)(None)
    fake.given[0].end(fake.exceptions.NodeDiedError())
    assert engine.wait() == [(task(3), Death(LOST))]
    assert len(fake.given) == 1 + ray_engine._MOVES


def test_what_ray_cannot_run_is_one_message(tmp_path, fake):
    engine = engine_of(tmp_path)
    engine.submit(task(0))
    fake.given[0].end(RuntimeError("a long story\nModuleNotFoundError: No module named 'trimesh'"))
    with pytest.raises(
        ClusterError, match=r"No module named .trimesh.\. halfphysics .* installed on"
    ):
        engine.wait()


def test_jobs_bound_what_runs_on_a_cluster_that_has_more(tmp_path, fake):
    engine = engine_of(tmp_path, jobs=2)
    assert engine.slots == 2
    for i in range(5):
        engine.submit(task(i))
    assert len(fake.given) == 2
    fake.given[0].end()
    engine.wait()
    assert len(fake.given) == 3
    engine.close()
    assert fake.cancelled == fake.given[1:]  # a foreign Ray goes on without us
    assert engine.wait() == []


def test_slots_follow_the_cluster(tmp_path, fake, monkeypatch):
    monkeypatch.setattr(ray_engine, "_REFRESH", 0.0)
    fake.cores = 0
    engine = engine_of(tmp_path)
    assert engine.slots == 1  # waiting tasks make a cluster grow if it can
    fake.cores = 6000
    engine.wait()
    assert engine.slots == 6000


def test_shares_of_the_memory_follow_the_cluster(tmp_path, fake, monkeypatch):
    """All tasks together have what was said, however many cores there are."""
    monkeypatch.setattr(ray_engine, "_REFRESH", 0.0)
    engine = RayEngine(tmp_path, memory=8.0, function=None)
    for cores, tasks in ((4, 4), (10, 10), (2, 2), (6000, 16)):
        fake.cores = cores
        engine.wait()
        assert engine.slots == tasks
        engine.submit(task(0))
        *_, share, _ = fake.given.pop().order
        assert share == 8 * GIB // tasks
        engine._under_way.clear()
    for i in range(20):
        engine.submit(task(i))
    assert len(fake.given) == 16, "a task cannot live on less than half a GiB"


def test_another_program_on_a_machine_stops_the_sweep(tmp_path, fake, monkeypatch):
    engine = engine_of(tmp_path)
    monkeypatch.setattr(ray_engine, "code_hash", lambda: "another")  # on the cluster
    engine.submit(task(0))
    fake.given[0].end()
    ((_, done),) = engine.wait()
    assert "Install the same versions on all machines" in done.stop


def test_without_ray_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'halfphysics\[ray\]'"):
        RayEngine(tmp_path)


def test_impossible_numbers_are_said_before_ray_starts(tmp_path):
    with pytest.raises(InputError, match="jobs: found 0, expected at least 1"):
        RayEngine(tmp_path, 0)
    with pytest.raises(InputError, match="memory: found 0 GiB"):
        RayEngine(tmp_path, 1, 0.0)
    with pytest.raises(InputError, match="memory: found inf GiB"):
        RayEngine(tmp_path, 1, float("inf"))


@needs_ray
@pytest.mark.parametrize("address", ["127.0.0.1:1", "ray://127.0.0.1:1", "127.0.0.1:x"])
def test_a_cluster_that_is_not_there_is_one_message(tmp_path, address):
    with pytest.raises(ClusterError, match=f"ray: cannot use {address}: .*`ray start --head`"):
        RayEngine(tmp_path, address=address)


class Killer(Told):
    """Kills the process whose number is in a file, as soon as there is one."""

    def __init__(self, path):
        super().__init__()
        self.path, self.over = path, threading.Event()
        self.thread = threading.Thread(target=self.watch)

    def watch(self):
        while not self.over.wait(0.05):
            if self.path.exists():
                os.kill(int(self.path.read_text()), signal.SIGKILL)
                return

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()


@needs_ray
def test_a_worker_killed_mid_run_costs_nothing_and_bytes_are_the_local_ones(tmp_path, capfd):
    """Two workers; one is killed from outside while it simulates, one variant kills its own."""
    plan = planned(tmp_path, PLAN.replace("[0.2, 0.4, 0.6, 0.8]", "[0.2, 0.8]"))
    local, far, signed = tmp_path / "local", tmp_path / "far", tmp_path / "pid"

    def waits_to_be_killed(folder, task):
        if task.kind == "batches" and task.first == 0 and not signed.exists():
            opened(folder)[1].sample(0)
            replaced = signed.with_suffix(".new")
            replaced.write_text(str(os.getpid()))
            replaced.rename(signed)
            time.sleep(60.0)
        return deadly(folder, task)

    with (
        Store(local, plan) as store,
        contextlib.closing(LocalEngine(local, 2, 2.0, function=deadly)) as engine,
    ):
        there = run(store, engine, Told())
    ray.cloudpickle.register_pickle_by_value(sweep_case)
    try:
        with (
            Store(far, plan) as store,
            contextlib.closing(
                RayEngine(far, 2, 2.0, address="local", function=waits_to_be_killed)
            ) as engine,
            Killer(signed) as killer,
        ):
            found = run(store, engine, killer)
    finally:
        ray.cloudpickle.unregister_pickle_by_value(sweep_case)
    assert signed.exists()
    # That variant, and the variant's own twice in its batch and twice alone.
    assert killer.deaths >= 5
    assert (found.samples, found.skipped, found.failures) == (5, 0, 1)
    assert replace(found, folder=local) == there
    assert data(far) == data(local)
    (failure,) = map(json.loads, (far / "failures.jsonl").read_text().splitlines())
    assert (failure["number"], failure["cause"]) == (5, DIED)
    assert capfd.readouterr().out == ""
