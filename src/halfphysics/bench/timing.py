"""Timing in turns: ours, the peer, the peer, ours, and so on.

By processor time: it is the clock's on a quiet machine, and on a busy one does not count the time
that others had the core. Were a side to use several threads, all of them would count.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from halfphysics.bench.record import Options

A = TypeVar("A")
B = TypeVar("B")


@dataclass(frozen=True, kw_only=True)
class Timing(Generic[A, B]):
    """Processor time per pass [s] of every timed run, and what the untimed run returned."""

    ours: tuple[float, ...]
    peer: tuple[float, ...]
    result: A
    peer_result: B

    def rates(self, frames: int) -> tuple[float, ...]:
        """Ours in frames per second."""
        return tuple(frames / seconds for seconds in self.ours)

    def peer_rates(self, frames: int) -> tuple[float, ...]:
        """The peer's in frames per second."""
        return tuple(frames / seconds for seconds in self.peer)


def in_turns(ours: Callable[[], A], peer: Callable[[], B], options: Options) -> Timing[A, B]:
    """Time two functions in turns, after one untimed pass of each.

    Who goes first alternates, so that a machine that slows down or speeds up favours neither.
    """
    result, loops = _warm(ours, options.least)
    peer_result, peer_loops = _warm(peer, options.least)
    seconds: tuple[list[float], list[float]] = ([], [])
    turn = [(seconds[0], ours, loops), (seconds[1], peer, peer_loops)]
    for _ in range(options.repeats):
        for out, work, times in turn:
            out.append(_seconds(work, times))
        turn.reverse()
    return Timing(
        ours=tuple(seconds[0]), peer=tuple(seconds[1]), result=result, peer_result=peer_result
    )


def alone(ours: Callable[[], A], options: Options) -> Timing[A, None]:
    """Time a function that has no peer, after one untimed pass."""
    result, loops = _warm(ours, options.least)
    seconds = tuple(_seconds(ours, loops) for _ in range(options.repeats))
    return Timing(ours=seconds, peer=(), result=result, peer_result=None)


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
