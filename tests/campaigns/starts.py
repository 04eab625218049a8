"""Starts inside by the hundred: one row of numbers each, a table per kind.

    PYTHONPATH=tests python -m campaigns.starts [--seconds 600] [--log starts.jsonl] [--only KIND]
        [--shard 0/2] [--seed 0] [--contact skin] [--data DATA] [--case KIND-SEED] [--summary]

Kinds take turns, so any part of the campaign is a fair sample; logged cases are not run again.
`--seed` sets the first seed: choose one that was not used before. `PYTHONPATH` chooses the
build that is judged.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np

from halfphysics.simulation.simulator import Simulator
from support.shards import shard
from support.starts import cases as starts
from support.starts import objects as starts_things
from support.starts.cases import Case
from support.starts.judge import StartJudge
from support.starts.objects_judge import ObjectJudge
from support.starts.solids import EXACT

KINDS = (*starts.KINDS, *starts_things.KINDS)
#: Out: this share of a kind's cases within `SOON`, and all within `LATEST` [s].
SHARE, SOON, LATEST = 0.95, 0.5, 1.0
#: A vertex exceeds its speed in the motion by no more than this [m/s]; the same for objects.
FASTER = 1.2
#: Tolerance of unblocked joints [rad].
FREE = np.deg2rad(1.0)
#: A vertex that the motion keeps inside stays this near to the surface [m].
NEAR = 0.002
#: The slowest run that still progresses [frames/s], and the longest wait for one [s].
RATE, PATIENCE = 5.0, 5.0
#: Largest lost share of the time.
LOST = 0.005


def run(case, contact, data):
    """The numbers of one case."""
    thing = case.kind in starts_things.KINDS
    make = starts_things.build if thing else starts.build
    start = make(case, contact, data)
    settings = replace(start.settings, contact=contact)
    motion = start.motion
    simulator = Simulator(start.scene, body=starts.body(), settings=settings, fps=motion.fps)
    begin = time.perf_counter()
    simulator.reset(motion[0])
    frames = []
    for t in range(1, len(motion)):
        frames.append(simulator.step(motion[t]))
        took = time.perf_counter() - begin
        if took > PATIENCE:
            break
    things = {}
    if thing:
        o = ObjectJudge(simulator, start.solids).judge(motion, frames)
        things = {"until": min(o["out"], 1e9), "touched": o["touched"]}
    v = StartJudge(simulator, start.solids).judge(motion, frames, **things)
    row = {
        "id": case.id,
        "kind": case.kind,
        "contact": contact,
        "form": start.form,
        "target": start.target,
        "root": settings.root,
        "drive": settings.drive_time,
        "stiffness": settings.stiffness,
        "fps": motion.fps,
        "depth_mm": 1e3 * v.depth,
        "held": v.held,
        "out": _number(v.out),
        "skin_out": _number(v.skin_out),
        "again_mm": 1e3 * v.again,
        "pair_mm": 1e3 * v.deeper_pair,
        "worst_mm": 1e3 * v.deeper_worst,
        "way_mm": 1e3 * v.deeper_way,
        "over_mm": 1e3 * v.deepest_way,
        "fresh_mm": 1e3 * v.fresh,
        "fresh": v.fresh_where,
        "fast": v.fast,
        "fast_after": v.fast_after,
        "free_deg": float(np.rad2deg(v.free)),
        "free": v.free_joint,
        "free_after_deg": float(np.rad2deg(v.free_after)),
        "face_deg": float(np.rad2deg(v.face)),
        "root_mm": 1e3 * v.root,
        "root_end_mm": 1e3 * v.root_end,
        "gap_mm": _number(1e3 * v.end_gap) if start.held else None,
        "lost": sum(f.lost_time for f in frames) * motion.fps / len(frames),
        "per_second": len(frames) / took,
        "thrown": None,
    }
    if thing:
        row |= {
            "depth_mm": 1e3 * o["depth"],
            "out": _number(o["out"]),
            "again_mm": _number(1e3 * o["again"]),
            "pair_mm": 1e3 * o["deeper"],
            "worst_mm": 1e3 * o["deeper"],
            "way_mm": 1e3 * o["deeper_way"],
            "fresh_mm": max(row["fresh_mm"], 1e3 * o["fresh"]),
            "thrown": o["thrown"],
        }
    return row


def _number(x):
    return float(x) if np.isfinite(x) else None


def complaints(row):
    """Broken guarantees of a row, except the share that is out within `SOON`."""
    out = []
    if row["out"] is None or row["out"] > LATEST:
        out.append("stays inside" if row["out"] is None else f"out after {row['out']:.2f} s")
    elif row["again_mm"] is None or row["again_mm"] > 1e3 * EXACT:
        out.append(f"inside again, {row['again_mm']} mm")
    if row["way_mm"] > 1e3 * EXACT:
        out.append(f"{row['way_mm']:.4f} mm deeper in a substep")
    if row["fresh_mm"] > 1e3 * EXACT:
        out.append(f"{row['fresh_mm']:.4f} mm into what it was clear of ({row['fresh']})")
    if row["fast"] > FASTER:
        out.append(f"a vertex at {row['fast']:.2f} m/s")
    if row["thrown"] is not None and row["thrown"] > FASTER:
        out.append(f"a thing at {row['thrown']:.2f} m/s")
    if row["free_deg"] > np.rad2deg(FREE):
        out.append(f"free {row['free']} off by {row['free_deg']:.2f} deg")
    if row["gap_mm"] is not None and row["out"] is not None and row["gap_mm"] > 1e3 * NEAR:
        out.append(f"{row['gap_mm']:.2f} mm from what holds it off")
    if row["per_second"] < RATE:
        out.append(f"{row['per_second']:.1f} frames/s")
    if row["lost"] > LOST:
        out.append(f"lost {100 * row['lost']:.1f} % of the time")
    return out


def line(row):
    """A row in one line."""
    gap = "" if row["gap_mm"] is None else f" gap {row['gap_mm']:.2f}"
    out = "never" if row["out"] is None else f"{row['out']:.3f} s"
    thrown = "" if row["thrown"] is None else f" thrown {row['thrown']:.2f}"
    return (
        f"{row['id']:16s} {row['form']:10s} {row['target']:5s} {row['depth_mm']:5.1f} mm "
        f"{row['held']:2d} hulls: out {out}, deeper pair {row['pair_mm']:.4f} "
        f"worst {row['worst_mm']:.4f} way {row['way_mm']:.4f}, fresh {row['fresh_mm']:.4f}, "
        f"fast {row['fast']:.2f} ({row['fast_after']:.2f}), free {row['free_deg']:.2f} "
        f"{row['free']}, root {row['root_mm']:.0f} mm{gap}{thrown}, "
        f"lost {100 * row['lost']:.1f} %, {row['per_second']:.0f} f/s"
    )


def summary(rows):
    """A table: per kind, and per form and target of all."""
    groups = {}
    for r in rows:
        drive = "alg1" if r["drive"] is None else "tau"
        setting = f"{drive} l{r['stiffness']:g} {r['root']}"
        for key in (("kind", r["kind"]), ("form", r["form"]), ("target", r["target"]),
                    ("set", setting), ("all", "")):  # fmt: skip
            groups.setdefault(key, []).append(r)
    head = (
        f"{'':20s}{'cases':>6s}{'good':>6s}{'<0.5s':>7s}{'<1s':>6s}{'never':>6s}{'again':>6s}"
        f"{'deeper: way':>12s}{'mm':>7s}{'ever':>6s}{'worst':>6s}{'pair':>6s}{'fresh':>6s}"
        f"{'fast':>6s}{'max':>7s}"
        f"{'free>1':>7s}{'max':>6s}{'gap>2':>6s}{'root mm':>8s}{'lost':>5s}{'f/s p5':>7s}"
    )
    lines = [head]

    def over(rs, key, limit):
        return sum(r[key] is not None and r[key] > limit for r in rs)

    order = {k: i for i, k in enumerate(("kind", "form", "target", "set", "all"))}
    for (what, name), rs in sorted(groups.items(), key=lambda g: (order[g[0][0]], g[0][1])):
        outs = np.array([np.inf if r["out"] is None else r["out"] for r in rs])
        tiny = 1e3 * EXACT
        fast = [max(r["fast"], r["thrown"] or 0.0) for r in rs]
        lines.append(
            f"{what + ' ' + name:20s}{len(rs):6d}{sum(not complaints(r) for r in rs):6d}"
            f"{100 * (outs <= SOON).mean():6.0f}%{100 * (outs <= LATEST).mean():5.0f}%"
            f"{np.isinf(outs).sum():6d}{over(rs, 'again_mm', tiny):6d}"
            f"{over(rs, 'way_mm', tiny):12d}{max(r['way_mm'] for r in rs):7.2f}"
            f"{over(rs, 'over_mm', tiny):6d}"
            f"{over(rs, 'worst_mm', tiny):6d}{over(rs, 'pair_mm', tiny):6d}"
            f"{over(rs, 'fresh_mm', tiny):6d}{sum(f > FASTER for f in fast):6d}{max(fast):7.2f}"
            f"{over(rs, 'free_deg', np.rad2deg(FREE)):7d}{max(r['free_deg'] for r in rs):6.1f}"
            f"{over(rs, 'gap_mm', 1e3 * NEAR):6d}{np.median([r['root_mm'] for r in rs]):8.0f}"
            f"{over(rs, 'lost', LOST):5d}{np.percentile([r['per_second'] for r in rs], 5):7.0f}"
        )
    return "\n".join(lines)


def read(log):
    return [json.loads(text) for text in log.read_text().splitlines()] if log.exists() else []


def cases(seed=0, only=""):
    """Kinds in turn, without end."""
    kinds = [k for k in KINDS if only in k]
    if not kinds:
        raise SystemExit(f"--only {only}: no such kind; there are {', '.join(KINDS)}")
    for i in count(seed):
        for kind in kinds:
            yield Case(kind, i)


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--data", type=Path, default=os.environ.get("HALFPHYSICS_TEST_DATA"))
    p.add_argument("--log", type=Path, default=Path("starts.jsonl"))
    p.add_argument("--seconds", type=float, default=60.0)
    p.add_argument("--cases", type=int, help="so many of each kind, whatever the time")
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--seed", type=int, default=0, help="of the first case of each kind")
    p.add_argument("--only", default="", help="kinds whose name contains this")
    p.add_argument("--case", help="one case, KIND-SEED: its row, nothing is written")
    p.add_argument("--contact", default="skin", choices=["skin", "parts"])
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    options = p.parse_args()
    data = None if options.data is None else Path(options.data)
    if options.case:
        row = run(Case.of(options.case), options.contact, data)
        print(json.dumps(row, indent=1))
        print(line(row), *complaints(row), sep="\n  ")
        return
    rows = [r for r in read(options.log) if r["contact"] == options.contact]
    rows = [r for r in rows if options.only in r["kind"]]
    done = {r["id"] for r in rows}
    k, n = options.shard
    end = time.monotonic() + (np.inf if options.cases else options.seconds)
    most = (options.cases or 10**9) * sum(options.only in kind for kind in KINDS)
    for i, case in enumerate(cases(options.seed, options.only)):
        if options.summary or i >= most or time.monotonic() > end:
            break
        if i % n != k or case.id in done:
            continue
        try:
            row = run(case, options.contact, data)
        except Exception:
            print(f"in case {case.id}", file=sys.stderr)
            raise
        rows.append(row)
        with options.log.open("a") as out:
            out.write(json.dumps(row) + "\n")
        print(line(row), flush=True)
    if rows:
        print(summary(rows))
        for row in rows:
            for text in complaints(row):
                print(f"{row['id']}: {text}")


if __name__ == "__main__":
    main()
