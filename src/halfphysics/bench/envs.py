"""Environments: steps per second by the clock, on all cores."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from halfphysics.base.machine import cores
from halfphysics.bench.record import Options, Record
from halfphysics.envs import policies
from halfphysics.envs.tasks import names, task_class

#: Episodes side by side.
WORLDS = 16


def envs(options: Options) -> Iterator[Record]:
    """Steps/s of every task, episodes beginning again as they end, by script and by chance."""
    for task in names():
        for words, policy in (("by script", policies.scripted), ("by chance", policies.random)):
            steps = 4 if options.quick else 150
            yield _measured(task, words, policy(task), steps, options)


def _measured(
    task: str, words: str, policy: policies.Policy, steps: int, options: Options
) -> Record:
    run = task_class(task)(WORLDS, threads=cores())
    for i in range(WORLDS):
        run.seed(i, i)
    rates, ended = [], 0
    # The first run is the warm-up.
    for timed in range(1 + options.repeats):
        begin = time.perf_counter()
        for _ in range(steps):
            for i in map(int, np.flatnonzero(run.over)):
                run.begin(i)
            run.step(policy(run.observe()))
            ended += int(run.over.sum()) if timed else 0
        rates.append(WORLDS * steps / (time.perf_counter() - begin))
    return Record(
        case="envs",
        setting=f"{task} {words}, {WORLDS} worlds, {cores()} threads",
        frames=WORLDS * steps,
        unit="steps/s",
        ours=tuple(rates[1:]),
        checks={"episodes that ended": (float(ended), None)},
    )
