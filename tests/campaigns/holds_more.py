"""Two people, feet, seats, a drawer and things put down: authored takes, bare and adapted.

    PYTHONPATH=src:tests python -m campaigns.holds_more --log more.jsonl [--how adapted]
                          [--only shared,push] [--case ID] [--summary]

As `campaigns.holds`: one row of figures a case (`support.carries.take_figures`), a star in the
table marks a figure that misses its limit. Logged cases are not run again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from pathlib import Path

from campaigns.holds import HOWS, read
from halfphysics.simulation.simulate import simulate
from support.carries.limits import failed, table
from support.carries.take_cases import all_cases, name_of, take_of
from support.carries.take_figures import CARRIED, LIMITS, take_figures


def prepared(take, how: str):
    """The motions to simulate: as recorded, or adapted to the recorded thing."""
    if how == "bare":
        return take.motions
    from halfphysics.adaptation.adapt import adapt

    sequence = take.sequence()
    return tuple(
        adapt(
            m,
            sequence.scene,
            b,
            sequence.recorded,
            grip=how == "adapted",
            others=[(take.motions[j], take.bodies[j]) for j in range(len(take.bodies)) if j != k],
        ).motion
        for k, (m, b) in enumerate(zip(take.motions, take.bodies, strict=True))
    )


def run(case, how="bare"):
    """The row of one case."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        take = take_of(case)
        begin = time.perf_counter()
        motions = prepared(take, how)
        adapting = time.perf_counter() - begin
        sequence = take.sequence()
        result = simulate(motions, sequence.scene, body=list(take.bodies))
    row = {
        "id": take.id,
        "how": how,
        "kind": take.kind,
        "noise": take.noise,
        "frames": len(result),
        "adapting_s": adapting,
        **take_figures(result, take, motions),
    }
    row["failed"] = failed(row, LIMITS)
    row["carried"] = not set(CARRIED) & set(row["failed"])
    return row


def campaign(cases, log, how="bare"):
    """Runs the cases that the log misses and appends their rows; returns all rows of the cases."""
    wanted = [name_of(case) for case in cases]
    done = {row["id"] for row in read(log) if row["how"] == how}
    with log.open("a") as out:
        for case in cases:
            if name_of(case) in done:
                continue
            try:
                row = run(case, how)
            except Exception:
                print(f"in case {name_of(case)}", file=sys.stderr)
                raise
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(f"{row['id']}: {', '.join(row['failed']) or 'all kept'}", file=sys.stderr)
    rows = {row["id"]: row for row in read(log) if row["how"] == how}
    return [rows[name] for name in wanted if name in rows]


def summary(rows) -> str:
    """How many rows keep each limit, by kind and of all."""
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    lines = [f"{'kept / measured':20s}" + "".join(f"{k:>10s}" for k in [*kinds, "all"])]
    for limit in LIMITS:
        cells = []
        for kind in [*kinds, None]:
            found = [limit.holds(row) for row in rows if kind in (None, row["kind"])]
            found = [verdict for verdict in found if verdict is not None]
            cells.append(f"{sum(found)}/{len(found)}" if found else "-")
        lines.append(f"{limit.short:20s}" + "".join(f"{c:>10s}" for c in cells))
    cells = []
    for kind in [*kinds, None]:
        found = [row["carried"] for row in rows if kind in (None, row["kind"])]
        cells.append(f"{sum(found)}/{len(found)}")
    lines.append(f"{'as recorded':20s}" + "".join(f"{c:>10s}" for c in cells))
    return "\n".join(lines)


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--log", type=Path, default=Path("holds_more.jsonl"))
    p.add_argument("--how", choices=HOWS, default="bare")
    p.add_argument("--only", default="", help="cases whose id contains one of these, by commas")
    p.add_argument("--case", help="one case by id: its row, nothing is written")
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    options = p.parse_args()
    cases = all_cases()
    if options.case:
        case = next(c for c in cases if name_of(c) == options.case)
        print(json.dumps(run(case, options.how), indent=1))
        return
    cases = [c for c in cases if any(o in name_of(c) for o in options.only.split(","))]
    if options.summary:
        names = {name_of(case) for case in cases}
        rows = [r for r in read(options.log) if r["how"] == options.how and r["id"] in names]
    else:
        rows = campaign(cases, options.log, options.how)
    print(table(rows, LIMITS))
    print()
    print(summary(rows))


if __name__ == "__main__":
    main()
