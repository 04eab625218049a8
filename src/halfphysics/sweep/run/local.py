"""The processes of this machine: the default engine of a sweep."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from halfphysics.base import machine
from halfphysics.base.workers import Death, Pool
from halfphysics.errors import InputError
from halfphysics.sweep.run.work import Done, Task, do

GIB = 2**30

#: Default share of the machine's memory that a sweep uses.
PART = 0.8
#: Least memory of a worker [bytes]: the program, and a clip, a body, a scene and a result.
LEAST = int(0.5 * GIB)
#: Recommended memory of a worker [bytes]; if memory is short there are fewer workers.
GOOD = int(1.0 * GIB)


def shares(jobs: int | None = None, gib: float | None = None) -> tuple[int, int]:
    """Number of worker processes, and the memory limit of each [bytes].

    Args:
        jobs: Number of processes; None: one per core, fewer if memory is short.
        gib: Memory for all processes together [GiB]; None: 80 % of the machine's.

    Raises:
        InputError: Invalid numbers, or less memory than the workers need.
    """
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs: found {jobs}, expected at least 1")
    whole = machine.memory()
    if gib is not None and not GIB * gib >= LEAST:
        raise InputError(f"memory: found {gib:g} GiB, expected at least {LEAST / GIB:g}")
    if gib is not None and GIB * gib > whole:
        raise InputError(
            f"memory: found {gib:g} GiB, expected at most the {whole / GIB:.4g} GiB that this "
            "machine, or the control group of this process, has"
        )
    total = int(PART * whole if gib is None else GIB * gib)
    if jobs is None:
        jobs = max(1, min(machine.cores(), total // GOOD))
    share = total // jobs
    if share < LEAST:
        raise InputError(
            f"memory: {total / GIB:.3g} GiB for {jobs} processes is {share / GIB:.2g} GiB each, "
            f"expected at least {LEAST / GIB:g}: at most {max(1, total // LEAST)} processes"
        )
    return jobs, share


class LocalEngine:
    """Worker processes of this machine.

    Args:
        folder: The folder of the sweep.
        jobs, memory: See `shares`.
        function: The function that the processes run.

    Raises:
        InputError: Invalid numbers.
    """

    def __init__(
        self,
        folder: Path,
        jobs: int | None = None,
        memory: float | None = None,
        *,
        function: Callable[[str, Task], Done] = do,
    ) -> None:
        self.slots, self.share = shares(jobs, memory)
        self._pool: Pool[Task, Done] = Pool(
            partial(function, str(folder)), self.slots, memory=self.share
        )

    def submit(self, task: Task) -> None:
        """Hand over a task."""
        self._pool.submit(task, alone=task.kind == "variants")

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """Outcomes of at least one task; the list is empty only if no task is in progress."""
        return self._pool.wait()

    def close(self) -> None:
        """End all processes."""
        self._pool.close()
