"""Timing in turns: from the first side to the last, then from the last to the first, and so on.

Processor time equals wall time on a quiet machine; on a busy machine it excludes the time of other
processes on the core. All threads of a side count.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from halfphysics.bench.record import Options

A = TypeVar("A")


@dataclass(frozen=True, kw_only=True)
class Timing(Generic[A]):
    """Processor time per pass [s] of every timed run, and the result of the untimed pass."""

    seconds: tuple[float, ...]
    result: A

    def rates(self, frames: int) -> tuple[float, ...]:
        """Rates of the timed runs in frames per second."""
        return tuple(frames / seconds for seconds in self.seconds)


def in_turns(works: Sequence[Callable[[], A]], options: Options) -> list[Timing[A]]:
    """Time functions in turns, after one untimed pass of each.

    The order alternates, so a machine that slows down or speeds up favours no side.
    """
    warm = [_warm(work, options.least) for work in works]
    seconds: list[list[float]] = [[] for _ in works]
    turn = [(out, work, loops) for out, work, (_, loops) in zip(seconds, works, warm, strict=True)]
    for _ in range(options.repeats):
        for out, work, loops in turn:
            out.append(_seconds(work, loops))
        turn.reverse()
    return [
        Timing(seconds=tuple(out), result=result)
        for out, (result, _) in zip(seconds, warm, strict=True)
    ]


def _warm(work: Callable[[], A], least: float) -> tuple[A, int]:
    """The result of an untimed pass, and the number of passes in a run."""
    start = time.process_time()
    result = work()
    # The first pass is the slowest, so the second gives the time of a pass.
    if least > 0.0:
        start = time.process_time()
        work()
    elapsed = time.process_time() - start
    return result, max(1, math.ceil(least / max(elapsed, 1e-6)))


def _seconds(work: Callable[[], object], loops: int) -> float:
    """Seconds per pass, without the garbage collector."""
    on = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        start = time.process_time()
        for _ in range(loops):
            work()
        # A coarse clock may show no difference.
        return max(time.process_time() - start, 1e-9) / loops
    finally:
        if on:
            gc.enable()
