"""The loop of a sweep: hands out batches, seals shards, and gets over the death of processes.

What it remembers is about shards that are open, at most twice as many tasks as the engine runs at
a time. Everything else is on disk, so that it may end at any moment and start again.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from halfphysics.errors import HalfPhysicsError
from halfphysics.sweep.run.engines import Death, Engine
from halfphysics.sweep.run.work import Done, Task

if TYPE_CHECKING:
    from halfphysics.sweep.plan.layout import Layout
    from halfphysics.sweep.store.store import Store

AHEAD = 2  # so many tasks for each slot are handed over
TARGET = 2.0  # a task should take so long [s],
RATE = 400.0  # and longer where more than so many tasks would end in a second: one process drives
_ENDING = 3  # what is left is shared out in so many tasks for each slot
_LEARNING = 0.3  # the weight of the latest task in what a batch is said to take
_TRIES = 2  # a batch, or a variant alone, whose process died runs so often in all
_HOPELESS = 50  # so many processes in a row may die, and no task end: more with many slots

_TOGETHER = "its process died, again and again, though each variant of its batch alone survived"


class SweepError(HalfPhysicsError):
    """A sweep that cannot go on: its outputs cannot be written, or processes die all the time."""


@dataclass(frozen=True)
class Report:
    """What a sweep has come to, with what was there before.

    Attributes:
        folder: Where it is.
        shards, samples, skipped, failures: Numbers of shards, of variants that are in them, that a
            condition of the plan left out, and that failed (``failures.jsonl``).
    """

    folder: Path
    shards: int
    samples: int
    skipped: int
    failures: int

    @property
    def variants(self) -> int:
        """How many variants that is."""
        return self.samples + self.skipped + self.failures


class Shards(Protocol):
    """What the driver asks of the outputs (`store.Store`)."""

    @property
    def layout(self) -> Layout:
        """Which variants, batches and shards there are."""

    def done(self, shard: int) -> bool:
        """Whether it is sealed."""

    def left(self, shard: int) -> Sequence[int]:
        """Its batches that have to be made, in order."""


class Progress(Protocol):
    """The one that is told what happens."""

    def begin(self, variants: int) -> None:
        """Work on so many variants in all begins."""

    def found(self, variants: int) -> None:
        """So many of them were done before."""

    def ended(self, task: Task, done: Done) -> None:
        """A task has ended."""

    def died(self, task: Task, death: Death) -> None:
        """A process has died."""


def run(store: Store, engine: Engine, progress: Progress, *, limit: float | None = None) -> Report:
    """Do all that is left of a sweep.

    Args:
        store: Its folder, begun.
        engine: What works; the caller closes it.
        progress: What is told.
        limit: How long a variant may take [s]; None: as long as it takes.

    Raises:
        SweepError: It cannot go on. What is done stays done; the same sweep continues.
    """
    Driver(store, engine, progress, limit).run()
    return Report(store.folder, **store.finish())


@dataclass
class _Suspect:
    """A batch whose variants are tried alone: how many are left to try, and which died of it."""

    left: int
    dead: tuple[tuple[int, str], ...] = ()


class Driver:
    """The state of a sweep that runs."""

    def __init__(
        self, store: Shards, engine: Engine, progress: Progress, limit: float | None = None
    ) -> None:
        self.store, self.engine, self.progress = store, engine, progress
        self._limit = limit
        self._under_way = 0
        self._first = deque[Task]()  # what goes before new batches
        self._shard = -1  # the shard that batches are taken from
        self._left = deque[int]()  # its batches that no process has yet
        self._open: dict[int, int] = {}  # shard -> batches that have not come back
        self._tries: dict[tuple[str, int], int] = {}  # deaths by kind of task and its first
        self._suspects: dict[int, _Suspect] = {}  # by batch
        self._pace: float | None = None  # what a batch takes [s]
        self._deaths = 0  # since a task ended
        self._layout = store.layout

    def run(self) -> None:
        """Do all that is to be done.

        Raises:
            SweepError: It cannot go on; what is done is on disk.
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
        """What is to be handed over next."""
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
        """Batches of the shard in hand that are neighbours, as many as fill a task."""
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
        """It may have been chance, or one of the task's variants: which is found out."""
        self._deaths += 1
        if self._deaths >= _HOPELESS + 2 * AHEAD * self.engine.slots:
            raise SweepError(
                f"{self._deaths} processes in a row died, and no task ended: {death.cause}. See "
                "what the system says about it (dmesg), or give them more memory (--memory) with "
                "fewer of them (--jobs)"
            )
        batches = range(task.first, task.first + task.count)
        if task.count > 1:
            # Each goes alone from now on, so that one variant costs little.
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
        """A variant has been tried alone; after the last one of a batch, it is made without them
        that died of it."""
        batch = task.first // self._layout.batch
        suspect = self._suspects[batch]
        suspect.left -= 1
        suspect.dead += dead
        if not suspect.left:
            self._first.append(Task("batches", task.shard, batch, dead=tuple(sorted(suspect.dead))))

    def _count(self, batches: Iterable[int]) -> int:
        return sum(len(self._layout.variants_of(batch)) for batch in batches)
