"""A small sweep for tests, and workers that misbehave, found by name in other processes."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from halfphysics.sweep.make import making
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.run.work import do, opened
from halfphysics.sweep.store.store import Store

#: 12 variants of 56 frames in six batches and two shards; the condition leaves one out.
PLAN = """
inputs:
  - scenarios: [kick_ball]
factors:
  scenario.fps: [10]
  objects.mass_factor: [0.5, 1, 2]
  objects.friction: [0.2, 0.4, 0.6, 0.8]
keep: objects.mass_factor < 2 or objects.friction < 0.8
outputs: {batch: 2, variants_per_shard: 8}
"""


def planned(folder: Path, text: str = PLAN) -> Plan:
    """The plan, in a file of this folder."""
    path = folder / "plan.yaml"
    path.write_text(text)
    return Plan.load(path)


def begun(folder: Path, plan: Plan) -> Store:
    """The folder of a sweep without a driver or workers."""
    store = Store(folder, plan)
    store.begin()
    store.close()
    opened.cache_clear()
    return store


def data(folder: Path) -> dict[str, bytes]:
    """All files of a sweep except its notes."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    names = {path.relative_to(folder).as_posix(): path for path in files}
    return {name: path.read_bytes() for name, path in names.items() if name[:5] != "work/"}


class Told:
    """Records the deaths that a driver reports."""

    def __init__(self):
        self.deaths = 0

    def begin(self, variants):
        pass

    def found(self, variants):
        pass

    def ended(self, task, done):
        pass

    def died(self, task, death):
        self.deaths += 1


class Here:
    """An engine that works in this process."""

    slots = 1

    def __init__(self, folder):
        self.folder, self.tasks = str(folder), []
        opened.cache_clear()

    def submit(self, task):
        self.tasks.append(task)

    def wait(self):
        task = self.tasks.pop(0)
        return [(task, do(self.folder, task))]

    def close(self):
        pass


def deadly(folder, task):
    """Variant 5 kills its process, variant 9 requests too much memory."""
    before = making.Maker.sample

    def sample(self, number, limit=None):
        if number == 5:
            os.kill(os.getpid(), signal.SIGKILL)
        if number == 9:
            bytearray(8 * 2**30)
        return before(self, number, limit)

    making.Maker.sample = sample
    try:
        return do(folder, task)
    finally:
        making.Maker.sample = before
