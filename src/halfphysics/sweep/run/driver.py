"""The loop of a sweep: hands out batches, seals shards, and recovers from the death of processes.

The driver keeps open shards only in memory, and at most twice as many tasks as the engine has
slots. Everything else is on disk, so the driver may end at any moment and start again.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from halfphysics.errors import HalfPhysicsError
from halfphysics.sweep.make.time_limit import check_limit
from halfphysics.sweep.run.engines import Death, Engine
from halfphysics.sweep.run.work import Done, Task

if TYPE_CHECKING:
    from halfphysics.sweep.plan.layout import Layout
    from halfphysics.sweep.store.store import Store

AHEAD = 2  # number of tasks handed over for each slot
TARGET = 2.0  # duration of a task [s],
RATE = 400.0  # longer if more than this many tasks would end per second: one process drives all
_ENDING = 3  # the last batches are divided into this many tasks for each slot
_LEARNING = 0.3  # weight of the latest task in the estimated duration of a batch
_TRIES = 2  # number of attempts at a batch, or a variant alone, whose process dies
_HOPELESS = 50  # deaths in a row without a finished task before the sweep stops; plus 4 per slot

_TOGETHER = "its process died, again and again, though each variant of its batch alone survived"


class SweepError(HalfPhysicsError):
    """A sweep cannot continue: its outputs cannot be written, or its processes keep dying."""


@dataclass(frozen=True)
class Report:
    """The totals of a sweep, including earlier runs.

    Attributes:
        folder: The folder of the sweep.
        shards, samples, skipped, failures: Numbers of shards, of variants in them, of variants that
            a condition of the plan left out, and of failed variants (``failures.jsonl``).
    """

    folder: Path
    shards: int
    samples: int
    skipped: int
    failures: int

    @property
    def variants(self) -> int:
        """Number of variants."""
        return self.samples + self.skipped + self.failures


class Shards(Protocol):
    """The interface of the outputs that the driver uses (`store.Store`)."""

    @property
    def layout(self) -> Layout:
        """The variants, batches and shards of the sweep."""

    def done(self, shard: int) -> bool:
        """Whether a shard is sealed."""

    def left(self, shard: int) -> Sequence[int]:
        """The batches of a shard that have to be made, in order."""


class Progress(Protocol):
    """Receives the events of a sweep."""

    def begin(self, variants: int) -> None:
        """The sweep starts; `variants` is the total number."""

    def found(self, variants: int) -> None:
        """An earlier run finished this number of variants."""

    def ended(self, task: Task, done: Done) -> None:
        """A task has ended."""

    def died(self, task: Task, death: Death) -> None:
        """A process has died."""


def run(store: Store, engine: Engine, progress: Progress, *, limit: float | None = None) -> Report:
    """Do all remaining work of a sweep.

    Args:
        store: The opened folder of the sweep (`begin` was called).
        engine: Runs the tasks; the caller closes it.
        progress: Receives the events.
        limit: Time limit of a variant [s]; None: no limit.

    Raises:
        InputError: An impossible limit.
        SweepError: The sweep cannot continue. Finished work stays; starting it again continues.
    """
    if limit is not None:
        check_limit(limit, "limit")
    Driver(store, engine, progress, limit).run()
    return Report(store.folder, **store.finish())


@dataclass
class _Suspect:
    """A batch whose variants run alone: number of variants left, and those whose process died."""

    left: int
    dead: tuple[tuple[int, str], ...] = ()


class Driver:
    """The state of a running sweep."""

    def __init__(
        self, store: Shards, engine: Engine, progress: Progress, limit: float | None = None
    ) -> None:
        self.store, self.engine, self.progress = store, engine, progress
        self._limit = limit
        self._under_way = 0
        self._first = deque[Task]()  # tasks that go before new batches
        self._shard = -1  # the shard that batches are taken from
        self._left = deque[int]()  # its batches that are not handed out yet
        self._open: dict[int, int] = {}  # shard -> batches that have not come back
        self._tries: dict[tuple[str, int], int] = {}  # deaths by kind and first number of a task
        self._suspects: dict[int, _Suspect] = {}  # by batch
        self._pace: float | None = None  # estimated duration of a batch [s]
        self._deaths = 0  # deaths since a task ended
        self._layout = store.layout

    def run(self) -> None:
        """Do all remaining work.

        Raises:
            SweepError: The sweep cannot continue; finished work is on disk.
        """
        self.progress.begin(self._layout.variants)
        while True:
            while self._under_way < AHEAD * self.engine.slots:
                task = self._next()
                if task is None:
                    break
                self.engine.submit(replace(task, limit=self._limit))
                self._under_way += 1
            if not self._under_way:
                return
            for task, outcome in self.engine.wait():
                self._under_way -= 1
                if isinstance(outcome, Death):
                    self._died(task, outcome)
                else:
                    self._ended(task, outcome)

    def _next(self) -> Task | None:
        """The next task to hand over."""
        while not self._first:
            if self._left:
                return self._batches()
            if self._shard + 1 == self._layout.shards:
                return None
            self._shard += 1
            self._take(self._shard)
        return self._first.popleft()

    def _take(self, shard: int) -> None:
        """Begin with a shard."""
        batches = self._layout.batches_of(shard)
        if self.store.done(shard):
            self.progress.found(self._count(batches))
            return
        self._left.extend(self.store.left(shard))
        self.progress.found(self._count(batches) - sum(self._count([b]) for b in self._left))
        self._open[shard] = len(self._left)
        if not self._left:
            self._first.append(Task("seal", shard))

    def _batches(self) -> Task:
        """Consecutive batches of the current shard, as many as fill a task."""
        rest = self._layout.batches - self._left[0]
        target = max(TARGET, self.engine.slots / RATE)
        most = 1 if self._pace is None else max(1, round(target / max(self._pace, 1e-3)))
        most = min(most, math.ceil(rest / (_ENDING * self.engine.slots)))
        first = self._left.popleft()
        count = 1
        while count < most and self._left and self._left[0] == first + count:
            self._left.popleft()
            count += 1
        return Task("batches", self._shard, first, count)

    def _ended(self, task: Task, done: Done) -> None:
        if done.stop:
            raise SweepError(done.stop)
        self._deaths = 0
        self._tries.pop((task.kind, task.first), None)
        if task.kind == "seal":
            del self._open[task.shard]
        elif task.kind == "batches":
            seconds = done.seconds / task.count
            was = seconds if self._pace is None else self._pace
            self._pace = was + _LEARNING * (seconds - was)
            self._suspects.pop(task.first, None)
            self._open[task.shard] -= task.count
            if not self._open[task.shard]:
                self._first.append(Task("seal", task.shard))
        else:
            self._tried(task, ())
        self.progress.ended(task, done)

    def _died(self, task: Task, death: Death) -> None:
        """Try again after a death: find out whether chance or a variant of the task caused it."""
        self._deaths += 1
        if self._deaths >= _HOPELESS + 2 * AHEAD * self.engine.slots:
            raise SweepError(
                f"{self._deaths} processes in a row died, and no task ended: {death.cause}. See "
                "what the system says about it (dmesg), or give them more memory (--memory) with "
                "fewer of them (--jobs)"
            )
        batches = range(task.first, task.first + task.count)
        if task.count > 1:
            # Each batch runs alone from now on, so that a fatal variant costs little.
            again = [Task(task.kind, task.shard, batch) for batch in batches]
        else:
            again = [task]
        for one in again:
            self._tries[one.kind, one.first] = self._tries.get((one.kind, one.first), 0) + 1
        tries = self._tries[task.kind, task.first]
        self.progress.died(task, death)
        if tries < _TRIES:
            self._first.extend(again)
            return
        del self._tries[task.kind, task.first]
        if task.kind == "variants":
            self._tried(task, ((task.first, death.cause),))
        elif task.kind == "seal":
            self._first.append(task)
        elif task.dead or task.first in self._suspects:
            numbers = self._layout.variants_of(task.first)
            known = dict(task.dead)
            dead = tuple((n, known.get(n, _TOGETHER)) for n in numbers)
            self._first.append(replace(task, dead=dead))
        else:
            numbers = self._layout.variants_of(task.first)
            self._suspects[task.first] = _Suspect(len(numbers))
            self._first.extend(Task("variants", task.shard, n) for n in numbers)

    def _tried(self, task: Task, dead: tuple[tuple[int, str], ...]) -> None:
        """Record that a variant ran alone; after the last one, make the batch without the fatal
        variants."""
        batch = task.first // self._layout.batch
        suspect = self._suspects[batch]
        suspect.left -= 1
        suspect.dead += dead
        if not suspect.left:
            self._first.append(Task("batches", task.shard, batch, dead=tuple(sorted(suspect.dead))))

    def _count(self, batches: Iterable[int]) -> int:
        return sum(len(self._layout.variants_of(batch)) for batch in batches)
