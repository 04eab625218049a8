"""Cost of a sweep beside its simulations: wall time, processor time by parts, memory."""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.bench.record import Options, Record
from halfphysics.bench.timing import in_turns
from halfphysics.errors import InputError
from halfphysics.simulation.simulate import simulate
from halfphysics.sweep.make.making import Maker, Sample
from halfphysics.sweep.make.vary import Workshop
from halfphysics.sweep.plan.inputs import Inputs
from halfphysics.sweep.plan.plan import Outputs, Plan, resolve_inputs
from halfphysics.sweep.plan.values import spec
from halfphysics.sweep.plan.variants import Variants
from halfphysics.sweep.run.driver import Report, run
from halfphysics.sweep.run.local import LocalEngine
from halfphysics.sweep.run.progress import Progress
from halfphysics.sweep.run.work import Done, Task, do
from halfphysics.sweep.store.data_card import DataCard
from halfphysics.sweep.store.store import Store

if TYPE_CHECKING:
    from halfphysics.base.workers import Death
    from halfphysics.results.result import Result
    from halfphysics.sweep.make.vary import Ready

#: A person walks up to a ball and kicks it: 167 frames, the fastest scenario to simulate.
SCENARIO = "kick_ball"
#: A person walks against a wall: 127 frames with contacts in most of them.
WALK = "walk_into_wall"
_VARIANTS, _QUICK_VARIANTS = 200, 3
_ALONE, _MANY, _POINTS = 100, 2000, 10
#: Largest number of timed runs: one run is long enough for a figure.
_REPEATS = 3


def sweep(options: Options) -> Iterator[Record]:
    """Whole sweeps: two processes beside one; one process beside its necessary work."""
    count = _QUICK_VARIANTS if options.quick else _VARIANTS
    yield _processes(SCENARIO, plan_of(count), options.repeats)
    # This row takes minutes.
    yield _processes(WALK, _walks(count), 1)
    few = _QUICK_VARIANTS if options.quick else _ALONE
    # One pass is long enough for a timed run.
    once = replace(options, quick=True, repeats=min(options.repeats, _REPEATS))
    plan = plan_of(few)
    variants = Variants(plan, resolve_inputs(plan))
    workshop = Workshop(plan)
    # A simulation does not change `ready`, so every turn simulates it again.
    ready = [workshop.make(variant) for variant in variants]
    whole, same, bare = in_turns(
        (
            lambda: _here(plan),
            lambda: len(_made(Maker(plan, variants), few)),
            lambda: len([_bare(one) for one in ready]),
        ),
        once,
    )
    for name, side in (("simulate, labels and files alone", same), ("simulate alone", bare)):
        yield Record(
            case="sweep",
            setting=f"{few} variants, one process; baseline: {name}",
            frames=few,
            unit="variants/s",
            ours=whole.rates(few),
            peer=side.rates(few),
            checks={"samples": (whole.result, side.result)},
        )


def parts(options: Options) -> Iterator[Record]:
    """Seconds per variant for each step of a sweep, beside those for `simulate`."""
    count = _QUICK_VARIANTS if options.quick else _ALONE
    plan = plan_of(count)
    found = [_parts(plan) for _ in range(min(options.repeats, _REPEATS))]
    for name in found[0]:
        yield Record(
            case="sweep-parts",
            setting=f"{name}, {count} variants",
            frames=count,
            unit="s",
            ours=tuple(one[name] for one in found),
            peer=tuple(one["simulate"] for one in found),
        )


def memory(options: Options) -> Iterator[Record]:
    """Memory of driver and workers at ten points of a long sweep; nothing beyond Linux."""
    if sys.platform != "linux":
        return
    count = _POINTS if options.quick else _MANY
    watch = _Watch()
    _clocked(plan_of(count), 2, watch)
    for name, held in (("driver", watch.driver), ("each of 2 workers", watch.workers)):
        megabytes = np.array(held) / 1e6
        # At the first point the processes still load modules and data.
        at = np.linspace(0.0, count, len(held) + 1)[2:]
        slope = np.polyfit(at, megabytes[1:], 1)[0]
        yield Record(
            case="sweep-memory",
            setting=f"{name}, {count} variants",
            frames=count,
            unit="MB",
            ours=tuple(megabytes.tolist()),
            checks={
                "growth [kB/variant]": (1000.0 * float(slope), None),
                "last over second point": (float(megabytes[-1] / megabytes[1]), None),
            },
        )


def plan_of(count: int) -> Plan:
    """A sweep of `count` variants of the scenario."""
    return Plan(
        inputs=(Inputs(scenarios=(SCENARIO,)),),
        factors={
            "objects.friction": spec({"uniform": [0.3, 1.0]}),
            "settings.stiffness": spec({"uniform": [0.0, 1.0]}),
        },
        samples=count,
        outputs=Outputs(),
    )


def _bare(ready: Ready) -> Result:
    """The part of a variant that a script would do: only `simulate`."""
    return simulate(
        ready.motions,
        ready.scene,
        body=ready.bodies,
        settings=ready.settings,
        allow_mismatch=ready.allow_mismatch,
    )


def _walks(count: int) -> Plan:
    """A sweep of `count` walks, each with another joint stiffness."""
    return Plan(
        inputs=(Inputs(scenarios=(WALK,)),),
        factors={"settings.stiffness": spec({"uniform": [0.0, 1.0]})},
        samples=count,
        outputs=Outputs(),
    )


class Here:
    """An engine in this process: a sweep without worker processes."""

    slots = 1

    def __init__(self, folder: Path) -> None:
        self._folder, self._tasks = str(folder), deque[Task]()

    def submit(self, task: Task) -> None:
        """Add a task to the queue."""
        self._tasks.append(task)

    def wait(self) -> list[tuple[Task, Done | Death]]:
        """Run the next task."""
        if not self._tasks:
            return []
        task = self._tasks.popleft()
        return [(task, do(self._folder, task))]

    def close(self) -> None:
        """Clear the queue."""
        self._tasks.clear()


class _Watch(Progress):
    """Records the memory of driver and workers after each part of the sweep [B]."""

    def __init__(self) -> None:
        super().__init__(bar=False, say=lambda line: None)
        self.driver: list[int] = []
        self.workers: list[int] = []

    def ended(self, task: Task, done: Done) -> None:
        """Record the memory at the end of a task."""
        super().ended(task, done)
        while (
            len(self.driver) < _POINTS
            and self.done * _POINTS >= (len(self.driver) + 1) * self.total
        ):
            self.driver.append(_held(os.getpid()))
            workers = [child.pid for child in multiprocessing.active_children()]
            self.workers.append(max((_held(pid) for pid in workers if pid), default=0))


def _held(process: int) -> int:
    """Memory of a process [bytes]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _processes(scenario: str, plan: Plan, repeats: int) -> Record:
    """Wall time of two processes beside one, including their start."""
    count = plan.samples
    seconds: dict[int, list[float]] = {1: [], 2: []}
    samples = 0
    order = (2, 1)
    for _ in range(min(repeats, _REPEATS)):
        for jobs in order:
            took, samples = _clocked(plan, jobs, Progress(bar=False, say=lambda line: None))
            seconds[jobs].append(took)
        order = order[::-1]
    return Record(
        case="sweep",
        setting=f"{count} of {scenario}, two processes by the clock; baseline: one process",
        frames=count,
        unit="variants/s",
        ours=tuple(count / took for took in seconds[2]),
        peer=tuple(count / took for took in seconds[1]),
        checks={"samples": (samples, samples)},
    )


def _clocked(plan: Plan, jobs: int, progress: Progress) -> tuple[float, int]:
    """Wall time of a sweep [s], including the start of its processes, and its number of samples."""
    with tempfile.TemporaryDirectory() as folder, Store(folder, plan) as store:
        start = time.perf_counter()
        engine = LocalEngine(Path(folder), jobs)
        try:
            report = run(store, engine, progress)
        finally:
            engine.close()
        return time.perf_counter() - start, _whole(report)


def _here(plan: Plan) -> int:
    """Run a sweep in this process; returns its number of samples."""
    with tempfile.TemporaryDirectory() as folder, Store(folder, plan) as store:
        report = run(store, Here(Path(folder)), Progress(bar=False, say=lambda line: None))
        return _whole(report)


def _whole(report: Report) -> int:
    """The number of samples of a sweep without failures; with failures the figures are invalid.

    Raises:
        InputError: Some variants failed.
    """
    if report.failures:
        raise InputError(
            f"bench: {report.failures} of {report.variants} variants failed, expected"
            " none: their traceback is above"
        )
    return report.samples


def _made(maker: Maker, count: int) -> list[Sample]:
    """The samples of a sweep, without driver, engine and folder."""
    made = (maker.sample(number) for number in range(count))
    return [one for one in made if isinstance(one, Sample)]


def _parts(plan: Plan) -> dict[str, float]:
    """Processor time of a variant by step [s]."""
    from halfphysics.labels import contact_labels
    from halfphysics.labels.events import events
    from halfphysics.sweep.make.card import card_of
    from halfphysics.sweep.make.sample import files_of

    variants, workshop = Variants(plan, resolve_inputs(plan)), Workshop(plan)
    # Reading, building and warming up happen once and do not count for a variant.
    contact_labels(workshop.run(workshop.make(variants[0])))
    spent = dict.fromkeys(("make", "simulate", "labels", "events and card", "files", "shard"), 0.0)
    last = time.process_time()

    def took(name: str) -> None:
        nonlocal last
        now = time.process_time()
        spent[name] += now - last
        last = now

    with tempfile.TemporaryDirectory() as folder, Store(folder, plan) as store:
        for batch in range(store.layout.batches):
            samples, card = [], DataCard()
            for number in store.layout.variants_of(batch):
                last = time.process_time()
                ready = workshop.make(variants[number])
                took("make")
                result = workshop.run(ready)
                took("simulate")
                labels = contact_labels(result)
                took("labels")
                one = card_of(plan, variants[number], ready, result, labels, events(result))
                card.sample(one)
                took("events and card")
                samples.append((variants[number].key, files_of(result, labels, one, whole=False)))
                took("files")
            record = {"skipped": 0, "failures": [], "inputs": {}, "sums": card.sums()}
            store.write_fragment(batch, samples, record)
            took("shard")
        for shard in range(store.layout.shards):
            store.seal(shard)
        store.finish()
        took("shard")
    return {name: max(seconds, 1e-9) / len(variants) for name, seconds in spent.items()}
