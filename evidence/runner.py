"""Tasks run in worker processes; each outcome is kept as soon as it is there."""

from __future__ import annotations

import importlib
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from evidence.model import Outcome, Task
from evidence.store import Store, identity
from halfphysics.base.workers import Death, Pool
from halfphysics.errors import HalfPhysicsError

_TRIES = 2  # runs of a task whose process dies


@dataclass(frozen=True)
class Job:
    """A task of a section."""

    section: str
    task: Task


@dataclass(frozen=True)
class Done:
    """A finished job: its time [s], and the cause of its failure ("" if it succeeded)."""

    job: Job
    seconds: float
    cause: str = ""


def function_of(task: Task) -> Callable[..., Outcome]:
    """The function that a task names."""
    module, name = task.function.split(":")
    found = importlib.import_module(module, "evidence")
    function: Callable[..., Outcome] = getattr(found, name)
    return function


def work(folder: Path, job: Job) -> Done:
    """Run a task and keep its outcome; an exception becomes the cause of its failure.

    The other tasks go on. An exception that is no error of the input is a bug: its traceback goes
    to stderr.
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
    """Run the jobs in `workers` processes (1: in this process) and yield them as they end.

    The longest jobs start first. A process that dies (killed, out of memory) loses only its
    current job, which runs once more.
    """
    waiting = sorted(jobs, key=lambda job: -job.task.seconds)
    if workers == 1 or len(waiting) < 2:
        for job in waiting:
            yield work(folder, job)
        return
    tries = dict.fromkeys(range(len(waiting)), 0)
    with Pool(partial(_numbered, folder), min(workers, len(waiting))) as pool:
        for index, job in enumerate(waiting):
            pool.submit((index, job))
        while tries:
            for (index, job), done in pool.wait():
                tries[index] += 1
                if isinstance(done, Death):
                    if tries[index] < _TRIES:
                        pool.submit((index, job))
                        continue
                    done = Done(job, 0.0, done.cause)
                del tries[index]
                yield done


def _numbered(folder: Path, numbered: tuple[int, Job]) -> Done:
    return work(folder, numbered[1])
