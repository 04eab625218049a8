"""Whether people stand, weigh and come back: scenarios, displaced clips, pushes, rooms.

    PYTHONPATH=src:tests python -m campaigns.ground [--data DATA] --log ground.jsonl
                          [--set root=recover --set strength=human] [--only sunk] [--case ID]
                          [--seconds 600] [--shard 0/2] [--summary] [--frames 90] [--shakes 4]
                          [--against other.jsonl]

One row of figures a person (`support.ground.figures`), each with its limit
(`support.ground.limits`); a star in the table marks a figure that misses it. `--set` changes
settings from their defaults; rows of other settings in the log are kept apart. Logged cases are
not run again.

Rooms are chaotic: a run of one says little of a change to the core. `--shakes 4` runs every case
four times, with its motions moved by 4 mm; `--against` compares a log with that of another
core, case by case: how many figures got better or worse, and by how much in the middle.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import sys
import time
import warnings
from pathlib import Path

import numpy as np

from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.ground.cases import all_cases, set_up
from support.ground.figures import figures, push_figures
from support.ground.limits import comparison, failed, late, summary, table
from support.shards import shard


def run(case, data=None, changes=None, frames=None):
    """The rows of one case, one a person; `frames`: no more than so many are run."""
    motions, scene, bodies = set_up(case, data)
    motions = [m[:frames] for m in motions]
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = simulate(motions, scene, body=list(bodies), settings=Settings(**(changes or {})))
    took = time.perf_counter() - begin
    rows = []
    for person in range(len(result.people)):
        row = {
            "id": case.id,
            "kind": case.kind,
            "what": case.what,
            "how": case.how,
            "person": person,
            "settings": label(changes),
            "frames": len(result),
            "per_second": len(result) / took,
            **figures(result, person),
        }
        if case.kind == "push":
            row.update(push_figures(result, case.what))
        row["back_late_s"] = late(row)
        row["failed"] = failed(row)
        rows.append(_plain(row))
    return rows


def _plain(row):
    return {
        name: (None if isinstance(value, float) and not np.isfinite(value) else value)
        for name, value in row.items()
    }


def label(changes) -> str:
    """Settings as text, in one order."""
    return ",".join(f"{name}={value}" for name, value in sorted((changes or {}).items()))


def settings_of(texts):
    """`name=value` texts as fields of `Settings`."""
    changes = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            changes[name] = ast.literal_eval(value)
        except (SyntaxError, ValueError):
            changes[name] = value
    return changes


def read(log):
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def campaign(cases, data, log, changes=None, seconds=np.inf, frames=None):
    """Runs the cases that the log misses and appends their rows; returns all rows of the cases."""
    wanted, told = {case.id: None for case in cases}, label(changes)
    done = {row["id"] for row in read(log) if row["settings"] == told}
    end = time.monotonic() + seconds
    with log.open("a") as out:
        for case in cases:
            if case.id in done:
                continue
            if time.monotonic() > end:
                break
            try:
                rows = run(case, data, changes, frames)
            except Exception:
                print(f"in case {case.id}", file=sys.stderr)
                raise
            for row in rows:
                out.write(json.dumps(row) + "\n")
                print(f"{row['id']}: {', '.join(row['failed']) or 'all kept'}", file=sys.stderr)
            out.flush()
    return [row for row in read(log) if row["id"] in wanted and row["settings"] == told]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--data", type=Path, default=os.environ.get("HALFPHYSICS_TEST_DATA"))
    p.add_argument("--log", type=Path, default=Path("ground.jsonl"))
    p.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    p.add_argument("--seconds", type=float, default=np.inf)
    p.add_argument("--frames", type=int, default=None, help="of each case, at most")
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--only", default="", help="cases whose id contains one of these, by commas")
    p.add_argument("--case", help="one case by id: its rows, nothing is written")
    p.add_argument("--shakes", type=int, default=0, help="runs of each case, a little beside it")
    p.add_argument("--against", type=Path, help="a log of another core, to compare with")
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    options = p.parse_args()
    data = None if options.data is None else Path(options.data)
    changes, cases = settings_of(options.set), all_cases(data, options.shakes)
    if options.case:
        case = next(c for c in cases if c.id == options.case)
        print(json.dumps(run(case, data, changes, options.frames), indent=1))
        return
    k, n = options.shard
    cases = [c for c in cases if any(o in c.id for o in options.only.split(","))][k::n]
    seconds = -1.0 if options.summary else options.seconds
    rows = campaign(cases, data, options.log, changes, seconds, options.frames)
    print(table(rows))
    print()
    print(summary(rows))
    if options.against:
        print()
        print(comparison(read(options.against), rows))


if __name__ == "__main__":
    main()
