"""Timing in turns: the first side to the last, the last to the first, and so on.

By processor time: it is the clock's on a quiet machine, and on a busy one does not count the time
that others had the core. Were a side to use several threads, all of them would count.
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
    """Processor time per pass [s] of every timed run, and what the untimed pass returned."""

    seconds: tuple[float, ...]
    result: A

    def rates(self, frames: int) -> tuple[float, ...]:
        """In frames per second."""
        return tuple(frames / seconds for seconds in self.seconds)


def in_turns(works: Sequence[Callable[[], A]], options: Options) -> list[Timing[A]]:
    """Time functions in turns, after one untimed pass of each.

    The side that goes first alternates: a machine that slows down or speeds up favours neither.
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
    """What an untimed pass returns, and how many passes make a run."""
    start = time.process_time()
    result = work()
    # The first pass is the slowest: the second says how long one takes.
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
        # A clock of coarse ticks may see none pass.
        return max(time.process_time() - start, 1e-9) / loops
    finally:
        if on:
            gc.enable()
