"""halfphysics bench: measure speed, beside a plain MuJoCo loop if the case has one."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from halfphysics.base.workers import THREADS
from halfphysics.cli.options import check_output, progress
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.bench import Options, Record

EXAMPLES = """\
halfphysics bench
halfphysics bench --case free --case wall
halfphysics bench --case free --motion walk.npz --json bench.json
halfphysics bench --quick --repeats 1"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Measure speed on one core: ours, ours with contact by parts, and the baseline, in turns.

    Ratios are medians over the runs of each turn; over 1 ours is faster.
    Rates are of this machine and of what else it does now. docs/benchmarks.md says more.
    """

    case: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """A case to measure, repeat for more; all if none is named."""
    motion: Path | None = None
    """A motion file to play in the free cases beside the built-in walk."""
    repeats: int = 7
    """Timed runs of each side."""
    quick: bool = False
    """Short clips and short runs: whether it works, not how fast."""
    json: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Write every single figure here too."""

    def run(self) -> None:
        """Measure, print and write the records."""
        from halfphysics import bench

        for name in self.case:
            if name not in bench.CASES:
                raise InputError(
                    f"--case: unknown case {name!r}, expected one of {', '.join(bench.CASES)}"
                )
        if self.json is not None:
            check_output(self.json, self.motion)
        options = self._options()
        machine = _machine()
        print(_head(machine, options))
        records: list[Record] = []
        for name, (_, _, what) in bench.CASES.items():
            if self.case and name not in self.case:
                continue
            found = list(_shown(name, bench.run(name, options)))
            tables = _tables(found) if found else f"left out: {bench.LEFT_OUT[name]}"
            print(f"\n{name}: {what}\n\n{tables}", flush=True)
            records += found
        if self.json is not None:
            _write(self.json, machine, options, records)
            print(f"\nwritten: {self.json}")

    def _options(self) -> Options:
        from halfphysics.bench import Options
        from halfphysics.motion.motion import Motion

        motion = None if self.motion is None else Motion.load(self.motion)
        name = "" if self.motion is None else self.motion.stem
        return Options(motion=motion, motion_name=name, quick=self.quick, repeats=self.repeats)


def _machine() -> dict[str, Any]:
    """Versions and machine properties on which the figures depend."""
    import platform

    import mujoco
    import numpy as np

    from halfphysics import __version__

    return {
        "halfphysics": __version__,
        "mujoco": mujoco.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "load": list(os.getloadavg()) if hasattr(os, "getloadavg") else None,
        "threads": {name: os.environ.get(name) for name in THREADS},
    }


def _head(machine: dict[str, Any], options: Options) -> str:
    load = machine["load"]
    busy = "" if load is None else f", load {load[0]:.2f} over the last minute"
    lines = [
        f"halfphysics {machine['halfphysics']}, MuJoCo {machine['mujoco']}, numpy "
        f"{machine['numpy']}, Python {machine['python']}, {machine['platform']}",
        f"{machine['cores']} cores, one used{busy}; {options.repeats} timed runs of each side",
        "rates by processor time: what else the machine does costs less than by the clock",
    ]
    if options.quick:
        lines.append("quick: clips and runs are cut short, the figures say little")
    return "\n".join(lines)


def _shown(name: str, records: Iterator[Record]) -> Iterator[Record]:
    """The records; at a terminal, the last setting measured is shown."""
    for record in records:
        if progress():
            print(f"\r\033[K{name}: {record.setting}", end="", file=sys.stderr)
        yield record
    if progress():
        print("\r\033[K", end="", file=sys.stderr)


def _tables(records: list[Record]) -> str:
    """The records of one case as tables: rates, then checks."""
    from halfphysics.cli.table import table

    first = records[0]
    head = ["setting", f"ours [{first.unit}]", "min", "max"]
    head += [] if first.parts is None else ["parts", "ours/parts"]
    head += [] if first.peer is None else ["baseline", "ours/baseline"]
    rates, checks = [head], [["setting"]]
    for name, (_, peer) in first.checks.items():
        checks[0] += [name] if peer is None else [name, "baseline"]
    for r in records:
        row = [r.setting, *map(_figure, (r.middle, min(r.ours), max(r.ours)))]
        for middle, ratio in ((r.parts_middle, r.parts_ratio), (r.peer_middle, r.ratio)):
            if middle is not None and ratio is not None:
                row += [_figure(middle), f"{ratio:.2f}"]
        rates.append(row)
        values = (value for pair in r.checks.values() for value in pair if value is not None)
        checks.append([r.setting, *(f"{value:.3g}" for value in values)])
    return "\n\n".join(table(rows) for rows in (rates, checks) if len(rows[0]) > 1)


def _figure(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def _write(path: Path, machine: dict[str, Any], options: Options, records: list[Record]) -> None:
    import json

    from halfphysics.base.atomic import atomic_write

    content = {
        "machine": machine,
        "repeats": options.repeats,
        "quick": options.quick,
        "records": [record.to_dict() for record in records],
    }
    with atomic_write(path) as handle:
        handle.write((json.dumps(content, indent=1) + "\n").encode())
