"""What a worker does: make variants, simulate them, label them, write them."""

from __future__ import annotations

import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning

if TYPE_CHECKING:
    from halfphysics.sweep.plan import Plan
    from halfphysics.sweep.store import Store
    from halfphysics.sweep.variants import Variant, Variants
    from halfphysics.sweep.vary import Workshop

_BUG = "(a bug: the traceback is on stderr)"


@dataclass(frozen=True)
class Task:
    """A piece of a sweep's work; done twice, it leaves the same files.

    Kinds: "batches" makes `count` batches of a shard from batch `first` on, "seal" makes a shard of
    its batches, "variants" simulates `count` variants from number `first` on and keeps nothing: to
    see whether the process survives them. `dead`: number and cause of the variants in these
    batches that are known to kill their process: they are not made, but failures.
    """

    kind: Literal["batches", "seal", "variants"]
    shard: int
    first: int = 0
    count: int = 1
    dead: tuple[tuple[int, str], ...] = ()


@dataclass(frozen=True)
class Done:
    """How a task ended: seconds of work, and numbers of variants.

    `kept` are in the fragments, `skipped` fell to a filter, `causes` are those of the failures.
    `stop`: why the sweep cannot go on at all ("" if it can), such as a full disk.
    """

    seconds: float
    kept: int = 0
    skipped: int = 0
    causes: tuple[str, ...] = ()
    size: int = 0
    stop: str = ""

    @property
    def variants(self) -> int:
        """How many variants this was."""
        return self.kept + self.skipped + len(self.causes)


def do(folder: str, task: Task) -> Done:
    """Do a task of the sweep in `folder`: what every engine runs, in whatever process.

    Raises nothing but `MemoryError`: what goes wrong with a variant is its failure, what goes
    wrong with the outputs stops the sweep.
    """
    start = time.perf_counter()
    try:
        work = _work(folder)
        if task.kind == "seal":
            work.store.seal(task.shard)
            return Done(time.perf_counter() - start)
        if task.kind == "variants":
            for number in range(task.first, task.first + task.count):
                work.made(number)
            return Done(time.perf_counter() - start)
        batches = [
            work.batch(batch, dict(task.dead))
            for batch in range(task.first, task.first + task.count)
        ]
    except MemoryError:
        raise
    except HalfPhysicsError as error:
        return Done(time.perf_counter() - start, stop=str(error))
    except Exception as error:
        traceback.print_exc()
        stop = f"{type(error).__name__}: {error} {_BUG}"
        return Done(time.perf_counter() - start, stop=stop)
    return Done(
        time.perf_counter() - start,
        kept=sum(record["samples"] for record in batches),
        skipped=sum(record["skipped"] for record in batches),
        causes=tuple(f["cause"] for record in batches for f in record["failures"]),
        size=sum(record["bytes"] for record in batches),
    )
