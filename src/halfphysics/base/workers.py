"""Worker processes that may die: a death loses one item, and the pool knows which.

A `Pool` runs one function in processes of its own. Each process has one item at a time and its own
pipe, so the death of a process (killed by the system for lack of memory, by a fault in native code
or by a user) is assigned to exactly one item.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing import connection
from multiprocessing.context import SpawnProcess
from typing import Any, Generic, TypeVar

from halfphysics.base.machine import limit_memory, offer_to_the_killer, resident
from halfphysics.errors import HalfPhysicsError

Item = TypeVar("Item")
Answer = TypeVar("Answer")

#: Environment variables that set the number of threads of numpy's libraries: one, or workers
#: compete for the cores.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

DIED = "its process died (killed, or out of memory)"
FULL = "it needs more memory than its process may have"

_STARTS = 3  # processes in a row that may die before they begin to work
_FULL = 0.75  # share of a worker's memory limit above which it is replaced
_PATIENCE = 2.0  # time for an idle worker to end [s]


@dataclass(frozen=True)
class Death:
    """Replaces the answer: the process that worked on the item has ended."""

    cause: str = DIED


class StartError(HalfPhysicsError):
    """Worker processes end before they begin to work."""


class _Worker:
    """A process as its parent sees it; `item` is the item that it works on."""

    def __init__(self, process: SpawnProcess, pipe: connection.Connection, alone: bool) -> None:
        self.process, self.pipe, self.alone = process, pipe, alone
        self.ready = self.busy = False
        self.item: Any = None

    def give(self, item: Any) -> bool:
        """Send an item; False if the worker died while it was idle."""
        try:
            self.pipe.send(item)
        except OSError:
            return False
        self.item, self.busy = item, True
        return True


class Pool(Generic[Item, Answer]):
    """Up to `slots` processes that answer items with `function`.

    The processes start when they are first needed, end with `close` (or the `with` block), and end
    on their own when the parent has ended. Only the parent handles Ctrl-C.

    Args:
        function: The work: a function of a module, which does not raise. A `MemoryError` that
            leaves it ends the process: a `Death` like any other.
        slots: Largest number of processes.
        memory: Memory limit of a process [bytes], enforced where the system can; a process that
            is near the limit between two items is replaced. None: no limit.
    """

    def __init__(
        self, function: Callable[[Item], Answer], slots: int, *, memory: int | None = None
    ) -> None:
        self.function, self.slots, self.memory = function, slots, memory
        self._queue: deque[tuple[Item, bool]] = deque()
        self._workers: list[_Worker] = []
        self._leaving: list[SpawnProcess] = []
        self._failed_starts = 0

    def __enter__(self) -> Pool[Item, Answer]:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def submit(self, item: Item, *, alone: bool = False) -> None:
        """Hand over an item; `alone`: run it in a process of its own."""
        self._queue.append((item, alone))
        self._dispatch()

    def wait(self) -> list[tuple[Item, Answer | Death]]:
        """Wait for at least one answer; the list is empty only if no item is in progress.

        Raises:
            StartError: Processes die as soon as they start.
        """
        found: list[tuple[Item, Answer | Death]] = []
        while not found and (self._queue or any(w.busy for w in self._workers)):
            self._dispatch()
            pipes = {worker.pipe: worker for worker in self._workers}
            for ready in connection.wait(list(pipes)):
                worker = pipes[ready]  # type: ignore[index]
                item = worker.item
                answer = self._heard(worker)
                if answer is not None:
                    found.append((item, answer))
        self._dispatch()
        return found

    def close(self) -> None:
        """End all processes; items in progress are lost."""
        self._queue.clear()
        for worker in list(self._workers):
            if worker.busy:
                worker.process.terminate()
            self._retire(worker)
        for process in self._leaving:
            process.join(_PATIENCE)
            if process.is_alive():
                process.kill()
                process.join()
        self._leaving.clear()

    def _dispatch(self) -> None:
        """Give queued items to idle workers, or to new processes."""
        self._leaving = [process for process in self._leaving if process.is_alive()]
        while self._queue:
            item, alone = self._queue[0]
            idle = next((w for w in self._workers if not w.busy), None)
            if idle is not None and not alone:
                if idle.give(item):
                    self._queue.popleft()
                else:
                    self._retire(idle)
                continue
            if len(self._workers) == self.slots:
                if idle is None:
                    return
                self._retire(idle)
            worker = self._start(alone)
            if worker.give(item):
                self._queue.popleft()
            else:
                self._retire(worker)
                self._begun(worker)

    def _heard(self, worker: _Worker) -> Answer | Death | None:
        """The answer that a worker has sent; None: a message without one."""
        try:
            said, held = worker.pipe.recv()
        except (EOFError, OSError):
            self._retire(worker)
            if not worker.busy:
                return None
            if worker.ready:
                return Death()
            # The worker never received the item: another process takes it.
            self._queue.appendleft((worker.item, worker.alone))
            self._begun(worker)
            return None
        if not worker.ready:
            worker.ready = True
            self._begun(worker)
            return None
        worker.item, worker.busy = None, False
        full = self.memory is not None and held > _FULL * self.memory
        if worker.alone or full or isinstance(said, Death):
            self._retire(worker)
        answer: Answer | Death = said
        return answer

    def _start(self, alone: bool) -> _Worker:
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(
            target=_serve, args=(theirs, self.function, self.memory), daemon=True
        )
        with _one_thread_each(), _held_back():
            process.start()
        theirs.close()
        worker = _Worker(process, ours, alone)
        self._workers.append(worker)
        return worker

    def _begun(self, worker: _Worker) -> None:
        """Count processes in a row that die before they begin to work; raise at the limit."""
        self._failed_starts = 0 if worker.ready else self._failed_starts + 1
        if self._failed_starts == _STARTS:
            worker.process.join(_PATIENCE)
            raise StartError(
                f"{_STARTS} worker processes in a row ended before they began to work (exit code "
                f"{worker.process.exitcode}). What they say stands above. A script of your own "
                'starts them under `if __name__ == "__main__":`'
            )

    def _retire(self, worker: _Worker) -> None:
        """Close a worker's pipe, which ends the worker."""
        worker.pipe.close()
        self._workers.remove(worker)
        self._leaving.append(worker.process)


def _serve(pipe: connection.Connection, function: Callable[[Any], Any], memory: int | None) -> None:
    """The main loop of a worker process; it ends with its pipe or its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    _lock_bars_here()
    offer_to_the_killer()
    if memory is not None:
        limit_memory(memory)
    # The end of the parent closes the pipe, which ends the worker as well.
    with contextlib.suppress(EOFError, BrokenPipeError):
        pipe.send((None, 0))
        while True:
            item = pipe.recv()
            try:
                answer = function(item)
            except MemoryError:
                pipe.send((Death(FULL), 0))
                break
            pipe.send((answer, resident()))
    # Exit at once, without the exit handlers of libraries: there is nothing to clean up.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _lock_bars_here() -> None:
    """Give tqdm a lock for threads only.

    Every progress bar, shown or not, otherwise creates a lock of the system for all processes,
    which a killed process leaves behind.
    """
    from tqdm import tqdm

    tqdm.set_lock(threading.RLock())


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes started in the block use one thread for linear algebra, unless the user sets it."""
    missing = [name for name in THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(missing, "1"))
    try:
        yield
    finally:
        for name in missing:
            del os.environ[name]


@contextlib.contextmanager
def _held_back() -> Iterator[None]:
    """Block Ctrl-C in this process during the block, and permanently in processes started in it."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
