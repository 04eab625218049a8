"""Whether recorded hands hold recorded things: authored recordings of carries, bare and adapted.

    PYTHONPATH=src:tests python -m campaigns.holds --log holds.jsonl [--how adapted]
                          [--layout mixed|each|memory|omomo|grab|...]
                          [--only suitcase,-gap-] [--case ID] [--seconds 600] [--shard 0/2]
                          [--summary] [--against other.jsonl]

`unsized` simulates a recording as it is with the default body, `bare` with one of the recorded
person's size, `adapted` what `halfphysics.adapt` makes of its motion,
`contact` the same without a grip. Every case is written as a file of a data set's layout, the
layouts in turn (`mixed`), in all (`each`) or in one, or not at all (`memory`), and loaded by
`load_sequence` with its defaults; what things stand on is added where the layout has none. One row
of figures a case (`support.carries.figures`), each with its limit (`support.carries.limits`); a
star in the table marks a figure that misses it. Logged cases are not run again; rows of all kinds
may share a log. `--against` compares with another log (or the same one) case by case, with its
`--against-how` rows.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import time
import warnings
from functools import lru_cache
from pathlib import Path

import numpy as np

from halfphysics.simulation.simulate import simulate
from support.carries.cases import all_cases
from support.carries.figures import change, figures
from support.carries.files import LAYOUTS
from support.carries.limits import comparison, failed, held, summary, table
from support.carries.loaded import MEMORY, loaded
from support.carries.people import bones_work
from support.carries.recordings import recording
from support.shards import shard

HOWS = ("unsized", "bare", "contact", "adapted")
#: All layouts in turn; every case in all layouts and from memory.
MIXED, EACH = "mixed", "each"
#: The recording of the last case, which may be run in several layouts.
recorded_as = lru_cache(maxsize=1)(recording)


def run(case, how="bare", layout=MEMORY):
    """The row of one case."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begin = time.perf_counter()
        made = recorded_as(case)
        recorded = time.perf_counter()
        its = loaded(made, layout, how)
        adapted = time.perf_counter()
        body = None if how == "unsized" else its.sequence.body
        result = simulate(its.sequence.motion, its.sequence.scene, body=body)
    sides = list(made.thing.grasps)
    row = {
        "id": case.id,
        "how": how,
        "layout": layout,
        "thing": case.thing,
        "way": case.way,
        "noise": case.noise,
        "fingers": case.fingers,
        "hands": len(sides),
        "stature": case.stature,
        "arms": case.arms if bones_work() else 1.0,
        "mass": its.sequence.scene.objects[case.thing].mass,
        "frames": len(result),
        "recording_s": recorded - begin,
        "adapting_s": adapted - recorded,
        "simulating_s": time.perf_counter() - adapted,
        "size_mm": its.size_mm,
        **change(its.recorded, its.motion, its.body, its.made.hold, sides),
        **figures(result, its.made, its.middle),
    }
    row["failed"] = failed(row)
    row["held"] = held(row)
    return {
        name: (None if isinstance(value, float) and not np.isfinite(value) else value)
        for name, value in row.items()
    }


def read(log):
    """The rows of a log; none where there is no file."""
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def layouts(cases, layout=MIXED):
    """The layout of every case, by id: one of all, or all in turn."""
    names = list(LAYOUTS)
    return {
        case.id: names[k % len(names)] if layout in (MIXED, EACH) else layout
        for k, case in enumerate(cases)
    }


def of(row, how, layouts) -> bool:
    """Whether a row is of that kind, in the layout that its case should have."""
    return row["how"] == how and row.get("layout", MEMORY) == layouts.get(row["id"])


def campaign(cases, log, how="bare", seconds=np.inf, layout=None):
    """Runs the cases that the log misses and appends their rows; returns all rows of the cases.

    `layout`: of every case, by id; None: from memory.
    """
    wanted = [case.id for case in cases]
    layout = layout or layouts(cases, MEMORY)
    done = {row["id"] for row in read(log) if of(row, how, layout)}
    end = time.monotonic() + seconds
    with log.open("a") as out:
        for case in cases:
            if case.id in done:
                continue
            if time.monotonic() > end:
                break
            try:
                row = run(case, how, layout[case.id])
            except Exception:
                print(f"in case {case.id}", file=sys.stderr)
                raise
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(
                f"{case.id} ({layout[case.id]}): {', '.join(row['failed']) or 'all kept'}",
                file=sys.stderr,
            )
    rows = {row["id"]: row for row in read(log) if of(row, how, layout)}
    return [rows[name] for name in wanted if name in rows]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--log", type=Path, default=Path("holds.jsonl"))
    p.add_argument("--how", choices=HOWS, default="bare")
    p.add_argument(
        "--layout",
        choices=(MIXED, EACH, MEMORY, *LAYOUTS),
        default=MIXED,
        help="the data set as whose file a case is written and loaded; mixed: all in turn; each: "
        "every case in all, and from memory",
    )
    p.add_argument("--seconds", type=float, default=np.inf)
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--only", default="", help="cases whose id contains one of these, by commas")
    p.add_argument("--case", help="one case by id: its row, nothing is written")
    p.add_argument("--against", type=Path, help="a log to compare with")
    p.add_argument("--against-how", choices=HOWS, default="bare", help="which rows of that log")
    p.add_argument("--against-layout", choices=(MIXED, MEMORY, *LAYOUTS), default=MEMORY)
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    options = p.parse_args()
    cases = all_cases()
    layout = layouts(cases, options.layout)
    if options.case:
        case = next(c for c in cases if c.id == options.case)
        print(json.dumps(run(case, options.how, layout[case.id]), indent=1))
        return
    k, n = options.shard
    cases = [c for c in cases if any(o in c.id for o in options.only.split(","))]
    order = np.random.default_rng(0).permutation(len(cases))[k::n]  # any part is a fair sample
    cases = [cases[i] for i in sorted(order)]
    seconds = -1.0 if options.summary else options.seconds
    if options.layout == EACH:
        end, rows = time.monotonic() + seconds, []
        for case, name in itertools.product(cases, (MEMORY, *LAYOUTS)):
            left = end - time.monotonic()
            rows += campaign([case], options.log, options.how, left, {case.id: name})
    else:
        rows = campaign(cases, options.log, options.how, seconds, layout)
    print(table(rows))
    print()
    print(summary(rows))
    if options.against:
        print()
        other = layouts(all_cases(), options.against_layout)
        before = [row for row in read(options.against) if of(row, options.against_how, other)]
        print(comparison(before, rows))


if __name__ == "__main__":
    main()
