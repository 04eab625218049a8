"""The cost of driving a large sweep, measured on a simulated cluster.

    PYTHONPATH=tests python -m campaigns.sweep_driver plan.yaml [--machines 1000] [--cores 16]
                                                      [--out FOLDER]

The driver, the numbering of variants, the folder, the sealing of shards, the manifest and the data
card are those of `halfphysics.sweep`; the machines are simulated
(`support.sweeps.simulated_cluster`), and no variant is computed. The time and memory of the driver
must not grow faster than the sweep does.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from halfphysics.base.machine import resident
from halfphysics.base.workers import Death
from halfphysics.errors import InputError
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.run.driver import Driver
from halfphysics.sweep.run.progress import bytes_text, time_text
from halfphysics.sweep.run.work import Done, Task
from halfphysics.sweep.store.store import Store
from support.sweeps.simulated_cluster import CORES, Cluster, SimulatedEngine

#: A sweep is cut into this many equal parts, to compare the last part's cost with the first's.
PARTS = 8


@dataclass(frozen=True, kw_only=True)
class Costs:
    """The driver's costs of a sweep.

    Times are processor time [s] of the driver alone, without the simulation of the cluster.

    Attributes:
        cluster: The simulated cluster.
        variants, batches, shards: Their numbers in the sweep.
        tasks, deaths, failures: Their numbers.
        begin: To list the inputs and open the folder.
        parts: To drive each of `PARTS` equal parts of the sweep.
        finish: To write manifest, data card and failures.
        step: The driver's longest time to answer.
        memory: Growth of the process [bytes], the simulated cluster included.
        manifest, records: Sizes of the manifest and of all records of shards [bytes].
        makespan: How long the sweep would take if the driver took no time [s].
        utilisation: The part of the cores' time for which they worked.
    """

    cluster: Cluster
    variants: int
    batches: int
    shards: int
    tasks: int
    deaths: int
    failures: int
    begin: float
    parts: tuple[float, ...]
    finish: float
    step: float
    memory: int
    manifest: int
    records: int
    makespan: float
    utilisation: float

    @property
    def driving(self) -> float:
        """Total seconds of the driver."""
        return self.begin + sum(self.parts) + self.finish

    @property
    def growth(self) -> float:
        """The driver's time for the second half of the sweep, over the first."""
        half = len(self.parts) // 2
        return sum(self.parts[half:]) / max(sum(self.parts[:half]), 1e-9)

    def __str__(self) -> str:
        cluster = self.cluster
        million = self.driving * 1e6 / self.variants
        parts = ", ".join(f"{part:.3g}" for part in self.parts)
        return "\n".join(
            (
                f"{cluster.machines:,} machines of {cluster.cores} cores, simulated: "
                f"{cluster.seconds:g} s a variant",
                f"sweep    {self.variants:,} variants, {self.batches:,} batches, {self.shards:,} "
                f"shards in {self.tasks:,} tasks; {self.deaths:,} deaths of processes, "
                f"{self.failures:,} variants that fail",
                f"takes    {time_text(self.makespan)}, with cores at work for "
                f"{100.0 * self.utilisation:.1f} % of it",
                f"driver   {self.driving:.3g} s of processor time, {million:.3g} s a million "
                f"variants, {100.0 * self.driving / self.makespan:.2g} % of the sweep's time",
                f"         {self.begin:.3g} s to begin, {self.finish:.3g} s to finish; eighths of "
                f"the sweep: {parts} s; second half over first {self.growth:.2f}",
                f"         longest answer {1000.0 * self.step:.3g} ms",
                f"memory   {bytes_text(self.memory)} more than before, with the simulated cluster",
                f"written  manifest {bytes_text(self.manifest)}, records of shards "
                f"{bytes_text(self.records)}",
            )
        )


def measure(plan: Plan, cluster: Cluster, folder: Path | None = None) -> Costs:
    """Drive a sweep on a simulated cluster.

    Args:
        plan: The sweep; its inputs are listed but not read.
        cluster: The behaviour of the machines.
        folder: Where records and manifest are written, missing or empty; None: a temporary one.

    Raises:
        InputError: The folder is not empty.
        FileError: The folder is not writable.
    """
    with ExitStack() as stack:
        if folder is None:
            temporary = tempfile.TemporaryDirectory(prefix="halfphysics-")
            folder = Path(stack.enter_context(temporary))
        elif folder.is_dir() and any(folder.iterdir()):
            raise InputError(
                f"{folder}: found files in it, expected an empty folder: what is written is no "
                "data. Without --out it is a temporary one"
            )
        before, start = resident(), time.process_time()
        store = stack.enter_context(Store(folder, plan))
        begin = time.process_time() - start
        engine = SimulatedEngine(folder, plan, cluster)
        watch = _Watch(engine)
        Driver(store, engine, watch).run()
        parts = watch.parts()
        start = time.process_time()
        totals = store.finish()
        finish = time.process_time() - start
        layout = store.layout
        records = layout.shard_folder.rglob("*.json")
        return Costs(
            cluster=cluster,
            variants=layout.variants,
            batches=layout.batches,
            shards=totals["shards"],
            tasks=engine.tasks,
            deaths=watch.deaths,
            failures=totals["failures"],
            begin=begin,
            parts=parts,
            finish=finish,
            step=engine.step,
            memory=max(engine.most, resident()) - before,
            manifest=(folder / "manifest.jsonl").stat().st_size,
            records=sum(path.stat().st_size for path in records),
            makespan=engine.now,
            utilisation=engine.busy / (engine.slots * engine.now),
        )


class _Watch:
    """Records the driver's time whenever another part of the sweep is done."""

    def __init__(self, engine: SimulatedEngine) -> None:
        self.deaths = 0
        self._engine = engine
        self._variants = self._done = 0
        self._marks = [0.0]
        self._start = time.process_time()

    def begin(self, variants: int) -> None:
        self._variants = variants

    def found(self, variants: int) -> None:
        self._done += variants

    def ended(self, task: Task, done: Done) -> None:
        # A task that tries one variant alone keeps no variant.
        self._done += done.variants if task.kind == "batches" else 0
        while len(self._marks) < PARTS and self._done * PARTS >= self._variants * len(self._marks):
            self._marks.append(self._time())

    def died(self, task: Task, death: Death) -> None:
        self.deaths += 1

    def parts(self) -> tuple[float, ...]:
        """The driver's time for each part; the last one's is until now."""
        marks = [*self._marks, self._time()]
        return tuple(after - before for before, after in pairwise(marks))

    def _time(self) -> float:
        return time.process_time() - self._start - self._engine.used


def main() -> None:
    """Measure the sweep of a plan file and print its costs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("plan", type=Path, help="the plan of the sweep; its inputs are only listed")
    parser.add_argument("--machines", type=int, default=1000, help="machines of the cluster")
    parser.add_argument("--cores", type=int, default=CORES, help="cores of each machine")
    parser.add_argument("--out", type=Path, help="an empty folder; a temporary one without it")
    given = parser.parse_args()
    cluster = Cluster(machines=given.machines, cores=given.cores)
    print(measure(Plan.load(given.plan), cluster, given.out))


if __name__ == "__main__":
    main()
