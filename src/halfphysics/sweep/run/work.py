"""The tasks of a worker: making and writing batches of variants, sealing shards."""

from __future__ import annotations

import time
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from halfphysics.errors import HalfPhysicsError
from halfphysics.sweep.plan.layout import INPUTS, PLAN, key_of

if TYPE_CHECKING:
    from halfphysics.sweep.make.making import Maker
    from halfphysics.sweep.store.store import Store


@dataclass(frozen=True)
class Task:
    """A unit of a sweep's work; running it twice leaves the same files.

    Kinds: "batches" makes `count` batches of a shard from batch `first` on, "seal" makes a shard
    from its batches, "variants" simulates `count` variants from number `first` on and keeps no
    output: it tests whether the process survives them. `dead`: number and cause of the variants in
    these batches that kill their process: they are not made but recorded as failures. `limit`: time
    limit of a variant [s]; a slower one is a failure too.
    """

    kind: Literal["batches", "seal", "variants"]
    shard: int
    first: int = 0
    count: int = 1
    dead: tuple[tuple[int, str], ...] = ()
    limit: float | None = None


@dataclass(frozen=True)
class Done:
    """The outcome of a task: seconds of work, and numbers of variants.

    `kept` variants are in the fragments, a condition of the plan left out `skipped`, `causes` has
    the cause of each failure. `size`: size of the fragments [bytes]. `stop`: why the sweep cannot
    continue, such as a full disk; "" if it can.
    """

    seconds: float
    kept: int = 0
    skipped: int = 0
    causes: tuple[str, ...] = ()
    size: int = 0
    stop: str = ""

    @property
    def variants(self) -> int:
        """Number of variants of the task."""
        return self.kept + self.skipped + len(self.causes)


def do(folder: str, task: Task) -> Done:
    """Do a task of the sweep in `folder`; every engine runs this function in its processes.

    Raises only `MemoryError`: an error of a variant is recorded as its failure, an error of the
    outputs stops the sweep.
    """
    start = time.perf_counter()
    records: list[Mapping[str, Any]] = []
    took: list[float] = []
    stop = ""
    try:
        fresh = not opened.cache_info().currsize
        store, maker = opened(folder)
        last = task.first + task.count
        start = time.perf_counter()
        if task.kind == "seal":
            store.seal(task.shard)
        elif task.kind == "variants":
            for number in range(task.first, last):
                maker.sample(number, task.limit)
        else:
            for batch in range(task.first, last):
                records.append(_batch(store, maker, batch, task, took))
            if fresh and len(took) > 1:
                # Do not count the startup of the process as time of the task.
                rest = sum(took[1:]) / len(took[1:])
                start += max(0.0, took[0] - rest)
    except MemoryError:
        raise
    except HalfPhysicsError as error:
        stop = str(error)
    except Exception as error:
        from halfphysics.sweep.make.making import BUG

        traceback.print_exc()
        stop = f"{type(error).__name__}: {error} {BUG}"
    return Done(
        time.perf_counter() - start,
        kept=sum(record["samples"] for record in records),
        skipped=sum(record["skipped"] for record in records),
        causes=tuple(failure["cause"] for record in records for failure in record["failures"]),
        size=sum(record["bytes"] for record in records),
        stop=stop,
    )


@lru_cache(maxsize=1)
def opened(folder: str) -> tuple[Store, Maker]:
    """The sweep in a folder with its loaded data, which a process keeps between tasks."""
    from halfphysics.sweep.make.making import Maker
    from halfphysics.sweep.plan.plan import InputList, Plan
    from halfphysics.sweep.plan.variants import Variants
    from halfphysics.sweep.store.store import Store

    plan = Plan.load(Path(folder) / PLAN)
    variants = Variants(plan, InputList(Path(folder) / INPUTS))
    store = Store(folder, plan)
    store.join()
    return store, Maker(plan, variants)


def _batch(
    store: Store, maker: Maker, batch: int, task: Task, took: list[float]
) -> Mapping[str, Any]:
    """Make a batch of a task and write each sample when it is made; appends the seconds of each
    variant to `took`."""
    from halfphysics.sweep.make.making import Sample
    from halfphysics.sweep.store.data_card import DataCard

    card, dead = DataCard(), dict(task.dead)
    record: dict[str, Any] = {"skipped": 0, "failures": [], "inputs": {}}

    def samples() -> Iterator[tuple[str, Mapping[str, bytes]]]:
        for number in store.layout.variants_of(batch):
            known = dead.get(number)
            start = time.perf_counter()
            made = maker.sample(number, task.limit) if known is None else maker.lost(number, known)
            took.append(time.perf_counter() - start)
            if isinstance(made, Sample):
                record["inputs"].update(made.inputs)
            if isinstance(made, Sample) and made.files:
                card.sample(made.card)
                yield key_of(number), made.files
            elif isinstance(made, dict):
                card.failure(made)
                record["failures"].append(made)
            else:
                card.skip(1)
                record["skipped"] += 1
        record["sums"] = card.sums()

    return store.write_fragment(batch, samples(), record)
