"""The campaign behind `campaigns/test_clear.py`: every case, one row of numbers each.

    PYTHONPATH=tests python -m campaigns.clear [--contact skin] [--data DATA] --log rows.jsonl
                           [--seconds 600] [--shard 0/2] [--only room] [--case ID] [--summary]
The judge checks the pieces that the core keeps clear (`clear_judge`): hulls of the skin, or
the rigid parts; `campaigns.skin` judges the skin itself in the same throws and rooms. Cases have
a fixed shuffled order, so any part of the campaign is a fair sample; logged cases are not
run again. `PYTHONPATH` chooses the build that is judged.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import warnings
import zlib
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from itertools import product
from pathlib import Path

import numpy as np

from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.motion.motion import Motion
from halfphysics.settings import AS_IT_IS, Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.clear_judge import Judge
from support.judges.person_hulls import CONTACTS
from support.rooms import furnished
from support.shards import shard
from support.throws import OBSTACLES, POSES, throw

STIFFNESS = (0.0, 1.0, 10.0)
DRIVES = (None, 0.02)
SPEEDS = (1.0, 2.0, 5.0, 10.0, 20.0)
#: h from 1/30 to 1/480 s.
THROW_STEPS = tuple(
    (fps, n) for fps in (30.0, 60.0, 120.0) for n in (1, 2, 4, 8, 16) if fps * n <= 480.0
)
CLIP_STEPS = tuple(product((30.0, 60.0, 120.0), (1, 4, 8, 16)))
CLIP_SPEEDS = (1.0, 2.0, 4.0)
#: Limits for a clip, relative to the time and to the steps (N >= 8, joints up to 5 m/s).
LOST, SHORTENED = 0.005, 0.01
#: Up to this speed of a clip; at four times its own up to 17 % are lost, in one case of seven.
HELD_SPEED = 2.0


@dataclass(frozen=True)
class Case:
    """One run. `what`: pose or clip; `where`: obstacle or seed of the room; `speed`: of the root
    [m/s], or a factor on the clip's speed."""

    kind: str
    what: str
    where: str
    speed: float
    fps: float
    substeps: int
    stiffness: float
    drive: float | None

    @cached_property
    def id(self) -> str:
        drive = "alg1" if self.drive is None else f"tau{self.drive:g}"
        return (
            f"{self.kind}-{self.what}-{self.where}-{self.speed:g}x-{self.fps:g}fps-"
            f"N{self.substeps}-l{self.stiffness:g}-{drive}"
        )

    @property
    def seed(self) -> int:
        return zlib.crc32(self.id.encode())


def _seed(case):
    return case.seed


def throw_cases():
    return [
        Case("throw", pose, kind, speed, fps, n, stiffness, drive)
        for pose, kind, speed, (fps, n), stiffness, drive in product(
            POSES, OBSTACLES, SPEEDS, THROW_STEPS, STIFFNESS, DRIVES
        )
    ]


def room_cases(data):
    return [
        Case("room", clip, str(seed), speed, fps, n, stiffness, drive)
        for (seed, clip), speed, (fps, n), stiffness, drive in product(
            enumerate(clips(data)), CLIP_SPEEDS, CLIP_STEPS, STIFFNESS, DRIVES
        )
    ]


@cache
def all_cases(data):
    """Shuffled; pairs of a throw and a room, so that any beginning has as many of both, in an order
    by chance, so that every shard has."""
    kinds = [throw_cases(), room_cases(data) if data is not None else []]
    ranked = [(rank, case) for cases in kinds for rank, case in enumerate(sorted(cases, key=_seed))]

    def place(ranked):
        rank, case = ranked
        return rank, 1 if case.kind == "throw" else 2 * (case.seed % 2)

    return [case for _, case in sorted(ranked, key=place)]


@cache
def _body():
    return Body.default()


@cache
def clips(data):
    """The real clips, name -> motion with its feet above z = 0."""
    found = {}
    for path in sorted((data / "motion").iterdir()):
        if path.suffix not in (".npz", ".bvh"):
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HalfPhysicsWarning)  # matched BVH joints
            motion = Motion.load(path)
        found[path.stem] = motion.grounded(_body(), z=0.002)
    return found


@cache
def _room(data, clip, seed):
    return furnished(clips(data)[clip], _body(), data / "meshes", seed)


def set_up(case, data):
    """Motion and scene of a case."""
    if case.kind == "throw":
        rng = np.random.default_rng(case.seed)
        return throw(case.what, case.where, case.speed, case.fps, _body(), rng)
    motion = clips(data)[case.what]
    scene = _room(data, case.what, int(case.where))
    faster = motion.with_frames(motion.translation, motion.rotations, fps=motion.fps * case.speed)
    return faster.resample(case.fps), scene


def run(case, data=None, contact="skin"):
    """The numbers of one case."""
    motion, scene = set_up(case, data)
    settings = Settings(
        contact=contact,
        substeps=case.substeps,
        stiffness=case.stiffness,
        drive_time=case.drive,
        record="substeps",
        **(AS_IT_IS if case.drive is None else {}),
    )
    simulator = Simulator(scene, body=_body(), settings=settings, fps=case.fps)
    simulator.world.stepper.keep_pieces(True)  # the judge sees every committed pose
    begin = time.perf_counter()
    simulator.reset(motion[0])
    frames = [simulator.step(motion[t]) for t in range(1, len(motion))]
    took = time.perf_counter() - begin
    start = simulator.world.start([motion[0]])[0]
    verdict = Judge(simulator).judge(start, frames)
    finite = all(np.isfinite(f.substeps).all() for f in frames)
    joints = _body().joints(motion)
    fastest = np.linalg.norm(np.diff(joints, axis=0), axis=2).max() * case.fps
    steps = len(frames) * case.substeps
    return {
        "id": case.id,
        **asdict(case),
        "contact": contact,
        "ok": bool(verdict.clear and finite and verdict.start > 0.0),
        "start_mm": _mm(verdict.start),
        "gap_mm": _mm(verdict.gap),
        "pair": "/".join(verdict.where[:2]),
        "pose": verdict.where[2],
        "inside": len(verdict.inside),
        "crossed": len(verdict.crossed),
        "first_crossed": list(verdict.crossed[0]) if verdict.crossed else None,
        "finite": finite,
        "fastest": round(float(fastest), 2),
        "frames": len(frames),
        "steps": steps,
        "lost": sum(f.lost_time for f in frames) * case.fps / len(frames),
        "shortened": int(sum(f.diagnostics["shortened"] for f in frames)),
        "residual_mm": 1e3 * max(f.diagnostics["residual"] for f in frames),
        "touched": sum(len(f.contacts.part) > 0 for f in frames),
        "per_second": len(frames) / took,
    }


def _mm(x):
    return None if np.isinf(x) else 1e3 * float(x)


def not_clear(row):
    """Texts for each violation of "nothing passes through"; none if there is none."""
    if row["ok"]:
        return []
    gap = "no" if row["gap_mm"] is None else f"{row['gap_mm']:.4f}"
    return [
        f"not clear: {gap} mm {row['pair']}, {row['inside']} of {row['steps']} poses, "
        f"{row['crossed']} crossings"
    ]


def held_back(row):
    """Texts for a clip held back more than allowed: time lost, steps shortened."""
    out = []
    if row["kind"] == "room" and row["speed"] <= HELD_SPEED:
        if row["lost"] > LOST:
            out.append(f"lost {100 * row['lost']:.2f} % of the time")
        short = row["shortened"] / row["steps"]
        if row["substeps"] >= 8 and row["fastest"] <= 5.0 and short > SHORTENED:
            out.append(f"shortened {100 * short:.2f} % of the steps")
    return out


def summary(rows):
    """A table: cases, not clear, distance, lost time, shortened share, speed, by group."""
    groups = {}
    for r in rows:
        keys = [
            (r["kind"], "all"),
            (r["kind"], r["what"]),
            (r["kind"], f"speed {r['speed']:g}"),
            (r["kind"], f"h 1/{r['fps'] * r['substeps']:g}"),
            (r["kind"], f"N {r['substeps']}"),
            (r["kind"], f"{'alg1' if r['drive'] is None else 'tau'} l{r['stiffness']:g}"),
        ]
        if r["kind"] == "throw":
            keys.append((r["kind"], r["where"]))
        for key in keys:
            groups.setdefault(key, []).append(r)
    lines = [
        f"{'':24s}{'cases':>6s}{'clear':>6s}{'cross':>6s}{'worst mm':>9s}{'lost %':>8s}"
        f"{'max':>7s}{'short %':>9s}{'max':>7s}{'f/s med':>9s}{'p5':>7s}"
    ]
    for (kind, name), rs in sorted(groups.items()):
        lost = np.array([r["lost"] for r in rs])
        short = np.array([r["shortened"] / r["steps"] for r in rs])
        steps = np.array([r["steps"] for r in rs])
        speed = np.array([r["per_second"] for r in rs])
        gaps = [r["gap_mm"] for r in rs if r["gap_mm"] is not None]
        lines.append(
            f"{kind + ' ' + name:24s}{len(rs):6d}{sum(r['ok'] for r in rs):6d}"
            f"{sum(r['crossed'] > 0 for r in rs):6d}{min(gaps, default=np.inf):9.4f}"
            f"{100 * lost.mean():8.3f}{100 * lost.max():7.2f}"
            f"{100 * (short * steps).sum() / steps.sum():9.3f}{100 * short.max():7.2f}"
            f"{np.median(speed):9.0f}{np.percentile(speed, 5):7.0f}"
        )
    return "\n".join(lines)


def read(log):
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def campaign(cases, data, log, contact="skin", seconds=np.inf, run=run):
    """Runs the cases missing in the log and appends them; returns all rows of these cases.

    run: (case, data, contact) -> row with at least "id" and "contact".
    """
    done = {(r["id"], r["contact"]) for r in read(log)}
    end = time.monotonic() + seconds
    with log.open("a") as out:
        for case in cases:
            if (case.id, contact) in done:
                continue
            if time.monotonic() > end:
                break
            try:
                row = run(case, data, contact)
            except Exception:
                print(f"in case {case.id}", file=sys.stderr)
                raise
            out.write(json.dumps(row) + "\n")
            out.flush()
    wanted = {c.id for c in cases}
    return [r for r in read(log) if r["id"] in wanted and r["contact"] == contact]


def options_of(doc, log, **more):
    """A parser for a campaign's command line; `more`: additional options, with their keywords."""
    p = argparse.ArgumentParser(description=doc.splitlines()[0])
    p.add_argument("--contact", choices=CONTACTS, default="skin")
    p.add_argument("--data", type=Path, default=os.environ.get("HALFPHYSICS_TEST_DATA"))
    p.add_argument("--log", type=Path, default=Path(log))
    p.add_argument("--seconds", type=float, default=np.inf)
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--only", default="", help="cases whose id contains this")
    for name, keywords in more.items():
        p.add_argument(f"--{name}", **keywords)
    p.add_argument("--case", help="one case by id: its row, nothing is written")
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    options = p.parse_args()
    options.data = None if options.data is None else Path(options.data)
    return options


def rows_of(options, cases, run):
    """Runs the requested cases and prints the results; returns the cases and their rows.

    With `--case` it prints that case's row and returns no rows.
    """
    if options.case:
        case = next(c for c in cases if c.id == options.case)
        print(json.dumps(run(case, options.data, options.contact), indent=1))
        return [], []
    k, n = options.shard
    cases = [c for c in cases if options.only in c.id][k::n]
    seconds = -1.0 if options.summary else options.seconds
    rows = campaign(cases, options.data, options.log, options.contact, seconds, run)
    return cases, rows


def complain(rows, complaints):
    """One line per complaint."""
    for row in rows:
        for text in complaints(row):
            print(f"{row['id']}: {text}")


def main():
    options = options_of(__doc__, "clear.jsonl")
    cases, rows = rows_of(options, all_cases(options.data), run)
    if not cases:
        return
    print(summary(rows))
    complain(rows, lambda row: not_clear(row) + held_back(row))
    gap = min((r["gap_mm"] for r in rows if r["gap_mm"] is not None), default=np.inf)
    steps, inside = sum(r["steps"] for r in rows), sum(r["inside"] > 0 for r in rows)
    crossed = sum(r["crossed"] > 0 for r in rows)
    print(
        f"{options.contact}: {len(rows)} of {len(cases)} cases, {steps} steps, inside in {inside}, "
        f"crossings in {crossed}, smallest gap {gap:.4f} mm"
    )


if __name__ == "__main__":
    main()
