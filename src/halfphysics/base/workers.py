"""Worker processes that may die: each costs only what it was doing, and it is known what that was.

A `Pool` runs one function in processes of its own, each of which has one item at a time and a
pipe of its own, so that a process that is killed (by the system for want of memory, by a fault in
native code, by a person) names exactly one item.
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

#: What numpy's libraries read to know how many threads to start: one, or workers get in each
#: other's way.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

DIED = "its process died (killed, or out of memory)"
FULL = "it needs more memory than its process may have"

_STARTS = 3  # so many processes in a row may die before they have begun to work
_FULL = 0.75  # a worker that holds more than this part of its share is replaced
_PATIENCE = 2.0  # how long an idle worker has to leave [s]


@dataclass(frozen=True)
class Death:
    """Instead of an answer: the process that worked on the item is gone."""

    cause: str = DIED


class StartError(HalfPhysicsError):
    """Processes end before they begin to work."""


class _Worker:
    """A process as its parent sees it; `item` is what it works on."""

    def __init__(self, process: SpawnProcess, pipe: connection.Connection, alone: bool) -> None:
        self.process, self.pipe, self.alone = process, pipe, alone
        self.ready = self.busy = False
        self.item: Any = None

    def give(self, item: Any) -> bool:
        """Whether it could be handed over; if not, the worker died while it had nothing to do."""
        try:
            self.pipe.send(item)
        except OSError:
            return False
        self.item, self.busy = item, True
        return True


class Pool(Generic[Item, Answer]):
    """Up to `slots` processes that answer items with `function`.

    They start when they are first needed, end with `close` (or the `with` block), and end by
    themselves when the parent is no more. Ctrl-C is the parent's to handle.

    Args:
        function: What they do: a function of a module, which does not raise. A `MemoryError` that
            it lets through ends the process: a `Death` like any other.
        slots: How many at most.
        memory: What one may hold [bytes]: more is refused to it where the system can, and one
            that comes near between two items is replaced. None: no limit.
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
        """Hand over an item; `alone`: to a process that does nothing else before or after."""
        self._queue.append((item, alone))
        self._dispatch()

    def wait(self) -> list[tuple[Item, Answer | Death]]:
        """What has been answered, at least one item; nothing only where nothing is under way.

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
        """End all processes; what they were doing is lost."""
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
        """Give what is queued to whoever is idle, or to new processes."""
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
        """What a worker says about its item; None: nothing about it."""
        try:
            said, held = worker.pipe.recv()
        except (EOFError, OSError):
            self._retire(worker)
            if not worker.busy:
                return None
            if worker.ready:
                return Death()
            # It never saw the item: another process may have it.
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
        """Count processes that die before they work: again and again, and there is a reason."""
        self._failed_starts = 0 if worker.ready else self._failed_starts + 1
        if self._failed_starts == _STARTS:
            worker.process.join(_PATIENCE)
            raise StartError(
                f"{_STARTS} worker processes in a row ended before they began to work (exit code "
                f"{worker.process.exitcode}). What they say stands above. A script of your own "
                'starts them under `if __name__ == "__main__":`'
            )

    def _retire(self, worker: _Worker) -> None:
        """Without a pipe there is nothing more to do: it ends."""
        worker.pipe.close()
        self._workers.remove(worker)
        self._leaving.append(worker.process)


def _serve(pipe: connection.Connection, function: Callable[[Any], Any], memory: int | None) -> None:
    """What a worker process does until there is nobody to work for."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    _lock_bars_here()
    offer_to_the_killer()
    if memory is not None:
        limit_memory(memory)
    # Who has asked and is no more ends a worker through its pipe as well.
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
    # At once: there is nothing to put in order, and no library has the last word.
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _lock_bars_here() -> None:
    """A progress bar, even one that is not shown, makes a lock for all processes, which one that
    is killed leaves behind in the system: a lock for its threads is all that it needs here."""
    from tqdm import tqdm

    tqdm.set_lock(threading.RLock())


def _end_with(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """What starts meanwhile uses one thread for its linear algebra, if nobody said otherwise."""
    missing = [name for name in THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(missing, "1"))
    try:
        yield
    finally:
        for name in missing:
            del os.environ[name]


@contextlib.contextmanager
def _held_back() -> Iterator[None]:
    """Ctrl-C waits, here and, for good, in the process that starts meanwhile."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
