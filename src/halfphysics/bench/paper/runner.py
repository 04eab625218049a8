"""Tasks done in processes; what is done is kept, whatever happens to the rest."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import connection
from pathlib import Path

from halfphysics.bench.paper.evidence import Outcome, Task
from halfphysics.bench.paper.store import Store, identity
from halfphysics.errors import HalfPhysicsError

#: What numpy's libraries read to know how many threads to start: one, or tasks get in each
#: other's way.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_TRIES = 2  # a task whose process died runs again so often in all


@dataclass(frozen=True)
class Job:
    """A task of a section."""

    section: str
    task: Task


@dataclass(frozen=True)
class Done:
    """What became of a job: how long it took [s], and why it failed ("" if it did not)."""

    job: Job
    seconds: float
    cause: str = ""


def function_of(task: Task) -> Callable[..., Outcome]:
    """The function that a task names."""
    module, name = task.function.split(":")
    found = importlib.import_module(module, "halfphysics.bench.paper")
    function: Callable[..., Outcome] = getattr(found, name)
    return function


def work(folder: Path, job: Job) -> Done:
    """Do a task and keep its outcome; what it raises is the cause of its failure.

    The others go on. Of what is no error of the input, a bug, the traceback goes to stderr.
    """
    start = time.perf_counter()
    try:
        of = identity(job.task)
        outcome = function_of(job.task)(**job.task.arguments)
        Store(folder).keep(job.section, job.task, outcome, of)
    except HalfPhysicsError as error:
        return Done(job, time.perf_counter() - start, str(error))
    except Exception as error:
        traceback.print_exc()
        cause = f"{type(error).__name__}: {error} (a bug: the traceback is on stderr)"
        return Done(job, time.perf_counter() - start, cause)
    return Done(job, time.perf_counter() - start)


def run(folder: Path, jobs: Sequence[Job], workers: int) -> Iterator[Done]:
    """What becomes of the jobs, as they end; `workers` processes, 1: this one.

    The longest start first. A process that dies (killed, out of memory) costs only what it was
    doing, which is tried once more.
    """
    waiting = sorted(jobs, key=lambda job: -job.task.seconds)
    if workers == 1 or len(waiting) < 2:
        for job in waiting:
            yield work(folder, job)
        return
    tries = dict.fromkeys(range(len(waiting)), 0)
    left = list(tries)
    while left:
        # Whoever was at work when a process died is suspected: each goes alone the next time.
        suspects = [i for i in left if tries[i]]
        batch = suspects[:1] or left
        for index, done in _pool(folder, [(i, waiting[i]) for i in batch], workers):
            if done is None:
                tries[index] += 1
                if tries[index] < _TRIES:
                    continue
                done = Done(waiting[index], 0.0, "its process died (killed, or out of memory)")
            left.remove(index)
            yield done


def _pool(
    folder: Path, jobs: Sequence[tuple[int, Job]], workers: int
) -> Iterator[tuple[int, Done | None]]:
    """As `run`; None for what was at work when a process died, which ends it all."""
    os.environ.update({name: os.environ.get(name, "1") for name in THREADS})
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(jobs)), context, initializer=_begin)
    try:
        queue = list(jobs)
        running: dict[Future[Done], int] = {}
        while queue or running:
            # No more is handed over than is at work, so that a death suspects few.
            while queue and len(running) < workers:
                index, job = queue.pop(0)
                running[pool.submit(work, folder, job)] = index
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            dead = False
            for future in finished:
                index = running.pop(future)
                try:
                    yield index, future.result()
                except BrokenProcessPool:
                    dead = True
                    yield index, None
            if dead:
                for index in running.values():
                    yield index, None
                return
        pool.shutdown()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()


def _begin() -> None:
    """In a new process: Ctrl-C is the parent's to handle, and without the parent there is nobody
    to work for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
