"""A simulated cluster for sweeps: an engine with its own clock, and a folder without fragments.

The fate of a variant depends on the seed and its number; the fates of processes and machines
depend on the seed and the order of tasks.
"""

from __future__ import annotations

import heapq
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.machine import resident
from halfphysics.base.workers import Death
from halfphysics.errors import InputError
from halfphysics.sweep.make.card import CHECKS
from halfphysics.sweep.make.making import failure
from halfphysics.sweep.make.provenance import versions
from halfphysics.sweep.plan.layout import INPUTS, Layout
from halfphysics.sweep.run.work import Done, Task
from halfphysics.sweep.store.data_card import SPREADS, SUMMED, counted
from halfphysics.sweep.store.fragments import Fragments
from halfphysics.sweep.store.sources import Sources
from halfphysics.sweep.store.store import Store

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.variants import Variant, Variants

#: Cores of a machine by default.
CORES = 16

CAUSE = "simulated cluster: this variant fails"

_SLOW = 3.0  # a straggling task takes this many times as long
_SHAPE = 4.0  # of the gamma distribution of times: half and twice the average are common
_NOTHING = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"  # its SHA-256


@dataclass(frozen=True, kw_only=True)
class Cluster:
    """The behaviour of the machines of the simulated cluster.

    Attributes:
        machines: Number of machines.
        cores: Number of cores of each machine.
        seconds: Mean time of a variant [s].
        sealing: Time to seal a shard [s].
        failing: Fraction of variants that fail.
        killing: Fraction of variants that always kill their process.
        dying: Fraction of tasks whose process dies, independent of the task.
        straggling: Fraction of tasks that take three times as long.
        seed: Seed of all random numbers.

    Raises:
        InputError: An impossible number.
    """

    machines: int
    cores: int = CORES
    seconds: float = 0.5
    sealing: float = 0.5
    failing: float = 1e-3
    killing: float = 1e-6
    dying: float = 1e-4
    straggling: float = 1e-3
    seed: int = 0

    def __post_init__(self) -> None:
        for name, least in (("machines", 1), ("cores", 1), ("seed", 0)):
            if getattr(self, name) < least:
                raise InputError(f"{name}: found {getattr(self, name)}, expected {least} or more")
        for name in ("seconds", "sealing"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name}: found {getattr(self, name)}, expected more than 0")
        for name in ("failing", "killing", "dying", "straggling"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError(f"{name}: found {getattr(self, name)}, expected 0 to 1")


class SimulatedEngine:
    """The cores of the simulated cluster, as an engine of a sweep.

    Attributes:
        slots: Cores of all machines.
        now: Time of the clock [s].
        busy: Seconds of cores that worked.
        tasks: Number of tasks handed over.
        used: Processor time of this process outside the driver [s].
        step: The most processor time of the driver between two calls [s].
        most: The most memory that this process held [bytes].
    """

    def __init__(self, folder: Path, plan: Plan, cluster: Cluster) -> None:
        self.slots = cluster.machines * cluster.cores
        self.now = self.busy = self.used = self.step = 0.0
        self.tasks = self.most = 0
        self._cluster = cluster
        self._store = _SimulatedStore(folder, plan, cluster)
        self._random = np.random.default_rng([cluster.seed, 0])
        self._queue = deque[Task]()
        self._running: list[tuple[float, int, Task, Done | Death]] = []
        self._left = time.process_time()

    def submit(self, task: Task) -> None:
        """Hand over a task."""
        start = self._enter()
        self.tasks += 1
        self._queue.append(task)
        self._begin()
        self._leave(start)

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """The next tasks that end; empty only if no task is under way."""
        start = self._enter()
        found = []
        if self._running:
            self.now, _, task, end = heapq.heappop(self._running)
            if task.kind == "seal" and isinstance(end, Done):
                self._store.seal(task.shard)
                self.most = max(self.most, resident())
            found.append((task, end))
            self._begin()
        self._leave(start)
        return found

    def close(self) -> None:
        """Stop all tasks."""
        self._queue.clear()
        self._running.clear()

    def _enter(self) -> float:
        start = time.process_time()
        self.step = max(self.step, start - self._left)
        return start

    def _leave(self, start: float) -> None:
        self._left = time.process_time()
        self.used += self._left - start

    def _begin(self) -> None:
        while self._queue and len(self._running) < self.slots:
            task = self._queue.popleft()
            seconds, end = self._end(task)
            self.busy += seconds
            heapq.heappush(self._running, (self.now + seconds, self.tasks, task, end))

    def _end(self, task: Task) -> tuple[float, Done | Death]:
        """The duration of a task, and its outcome."""
        straggles, dies, when = self._random.random(3).tolist()
        slow = _SLOW if straggles < self._cluster.straggling else 1.0
        if task.kind == "seal":
            done, killed = Done(slow * self._cluster.sealing), False
        else:
            done, killed = self._store.fates(task.shard).of(self._numbers(task), task.dead, slow)
        if killed or dies < self._cluster.dying:
            return when * done.seconds, Death()
        return done.seconds, done

    def _numbers(self, task: Task) -> range:
        """The variants of a task."""
        if task.kind == "variants":
            return range(task.first, task.first + task.count)
        of = self._store.layout.variants_of
        return range(of(task.first)[0], of(task.first + task.count - 1)[-1] + 1)


@dataclass(frozen=True)
class _Fates:
    """The fates of the variants of a shard, from number `first` on: arrays of one length."""

    first: int
    seconds: NDArray[np.float64]
    failing: NDArray[np.bool_]
    killing: NDArray[np.bool_]
    skipped: NDArray[np.bool_]

    def of(
        self, numbers: range, dead: tuple[tuple[int, str], ...], slow: float
    ) -> tuple[Done, bool]:
        """The outcome of a task with these variants, and whether one of them kills the process."""
        part = slice(numbers[0] - self.first, numbers[-1] + 1 - self.first)
        lost = np.zeros(len(numbers), dtype=bool)
        for number, _ in dead:
            lost[number - numbers[0]] = True
        skipped = self.skipped[part] & ~lost
        made = ~(lost | skipped)
        failed = int(np.count_nonzero(lost | (self.failing[part] & made)))
        left_out = int(np.count_nonzero(skipped))
        done = Done(
            slow * float(self.seconds[part].sum(where=made)),
            kept=len(numbers) - failed - left_out,
            skipped=left_out,
            causes=(CAUSE,) * failed,
        )
        return done, bool((self.killing[part] & made).any())


@dataclass(frozen=True)
class _SimulatedLayout(Layout):
    """All fragments are one empty file."""

    def fragment(self, batch: int) -> Path:
        return self.work / "empty.fragment"


class _SimulatedStore(Store):
    """A folder whose fragments are not on disk, but known from the seed; other files are."""

    def __init__(self, folder: Path, plan: Plan, cluster: Cluster) -> None:
        super().__init__(folder, plan)
        self._cluster = cluster
        #: Space for twice the shards of the tasks under way, and some more.
        open_shards = 2 * cluster.machines * cluster.cores // self.layout.batches_per_shard + 64
        self.fates = lru_cache(open_shards)(self._fates)
        self.layout.fragment(0).touch()

    @cached_property
    def layout(self) -> Layout:
        whole = super().layout
        return _SimulatedLayout(whole.folder, whole.variants, whole.batch, whole.per_shard)

    @cached_property
    def variants(self) -> Variants:
        """The variants of the plan, by number."""
        from halfphysics.sweep.plan.plan import InputList
        from halfphysics.sweep.plan.variants import Variants

        return Variants(self.plan, InputList(self.folder / INPUTS))

    @cached_property
    def _fragments(self) -> Fragments:
        return _SimulatedFragments(self)

    def _fates(self, shard: int) -> _Fates:
        batches = self.layout.batches_of(shard)
        first = self.layout.variants_of(batches[0])[0]
        numbers = range(first, self.layout.variants_of(batches[-1])[-1] + 1)
        cluster, random = self._cluster, np.random.default_rng([self._cluster.seed, 1, shard])
        skipped = np.zeros(len(numbers), dtype=bool)
        if self.plan.keep:
            kept = (self.variants.keeps(self.variants[number]) for number in numbers)
            skipped = ~np.fromiter(kept, dtype=bool, count=len(numbers))
        return _Fates(
            first,
            random.gamma(_SHAPE, cluster.seconds / _SHAPE, len(numbers)),
            random.random(len(numbers)) < cluster.failing,
            random.random(len(numbers)) < cluster.killing,
            skipped,
        )


class _SimulatedFragments(Fragments):
    """The records that fragments would have."""

    def __init__(self, store: _SimulatedStore) -> None:
        super().__init__(store.layout, store.identity, Sources(0))
        self._store = store
        self._empty = counted(())

    def read(self, batch: int) -> dict[str, Any]:
        layout, variants = self._store.layout, self._store.variants
        numbers = layout.variants_of(batch)
        fates = self._store.fates(layout.shard_of(batch))
        part = slice(numbers[0] - fates.first, numbers[-1] + 1 - fates.first)
        skipped = int(np.count_nonzero(fates.skipped[part]))
        lost = (fates.failing[part] | fates.killing[part]) & ~fates.skipped[part]
        failures = [failure(numbers[k], variants[numbers[k]], CAUSE) for k in np.flatnonzero(lost)]
        samples = len(numbers) - skipped - len(failures)
        numbers_ = {"samples": samples, "skipped": skipped, "failed": len(failures)}
        # Counts as long as real ones, of one batch of a shard: with realistic times.
        shown = numbers[:samples] if batch == layout.batches_of(layout.shard_of(batch))[0] else ()
        sums = counted(self._cards(shown), failures) if shown or failures else self._empty
        return {
            "batch": batch,
            "samples": samples,
            "skipped": skipped,
            "failures": failures,
            "sums": {**sums, "numbers": {**numbers_, "success": samples}},
            "inputs": {},
            "stats": {},
            "bytes": 0,
            "sha256": _NOTHING,
        }

    def remove(self, shard: int) -> None:
        """There is no file to remove."""

    def _cards(self, numbers: Iterable[int]) -> Iterator[dict[str, Any]]:
        """Cards of samples with events."""
        known = versions()
        for number in numbers:
            variant: Variant = self._store.variants[number]
            even = np.random.default_rng(number).random()
            yield {
                **variant.values(),
                "factors": variant.factors,
                "success": True,
                "checks": dict.fromkeys(CHECKS, True),
                "versions": known,
                **dict.fromkeys(SPREADS, even),
                **dict.fromkeys(SUMMED, 1),
            }
