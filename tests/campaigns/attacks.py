"""Attack scenes: what was, or could have been, slow or leaky, judged from outside at every substep.

    PYTHONPATH=tests python -m campaigns.attacks [--families soup,ring] [--seeds 3] [--frames 20]
        [--jobs 2] [--log rows.jsonl] [--no-judge]
    PYTHONPATH=tests python -m campaigns.attacks --fuzz 1000000 [--seeds 3] [--shard 0/2]
        --log fuzz.jsonl

One row of numbers a case: depth by `coal`, breaches that nothing reported, CPU time of the slowest
frames, lost time, memory of stepping. Prints the table and the ten slowest frames. `--fuzz` runs
random settings and mixtures of families for so many frames of every seed; it goes on with the
cases that its log does not have yet. `--shard k/n`, with a log for each: every n-th case from k on,
and of the fuzz the n-th part of the frames.
"""

from __future__ import annotations

import argparse
import itertools
import json
import multiprocessing
import os
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from halfphysics.settings import Settings
from halfphysics.simulation.frame import Frame
from halfphysics.simulation.simulator import Simulator
from support.attacks.families import FAMILIES
from support.attacks.stage import Attack, body
from support.judges.clear_judge import Judge, told_inside
from support.judges.coal_scene import Watch
from support.judges.person_hulls import pieces_of
from support.shards import shard

#: Accuracy of coal's own distances; the largest gap that is asked for [m].
ROUNDING, NEAR = 1e-6, 5e-4
#: CPU time of a frame of one person, of two [s]; memory that stepping takes [MB].
MOST_SECONDS = (0.05, 0.10)
MOST_MEMORY = 50.0
#: Work of a frame, in its budgets: what has begun when one ends is ended, and a few quiet attempts
#: follow.
MOST_WORK = 2.0
#: A case stops after this much CPU time [s]: the old core took 40 s for a frame.
PATIENCE = 120.0
#: What fuzzing draws from.
STEPS = ((30.0, 8), (30.0, 1), (60.0, 4), (120.0, 2), (15.0, 1))


@dataclass(frozen=True)
class Case:
    """One run: a family and a seed, with default settings at seed 0 and random ones at others;
    `fuzz` with scenery of another family besides."""

    family: str
    seed: int
    fuzz: bool = False

    @property
    def id(self) -> str:
        return f"{self.family}-{self.seed}" + ("-fuzz" if self.fuzz else "")

    @property
    def rng(self) -> np.random.Generator:
        kind = list(FAMILIES).index(self.family)
        return np.random.default_rng((self.seed, kind, int(self.fuzz)))


def set_up(case: Case) -> Attack:
    """The attack of a case; what a family sets itself, it keeps."""
    rng = case.rng
    attack = FAMILIES[case.family](rng)
    if case.seed == 0 and not case.fuzz:
        return attack
    fps, substeps = STEPS[rng.integers(len(STEPS))]
    drive = rng.choice([0.02, 0.02, 0.1, None])
    changes = {"substeps": int(substeps), "stiffness": float(rng.choice([0.0, 1.0, 10.0]))}
    changes["clearance"] = float(rng.choice([0.001, 0.001, 0.005, 1e-4]))
    attack.settings = {**changes, "drive_time": drive, **attack.settings}
    attack.motions = [m.resample(fps) if m.fps != fps else m for m in attack.motions]
    if not case.fuzz:
        return attack
    other = FAMILIES[str(rng.choice(list(FAMILIES)))](rng)
    for s in other.scene.statics.values():
        attack.scene.add_static(
            f"more_{s.name}", s.shape, position=s.position, quaternion=s.quaternion
        )
    return attack


@dataclass(frozen=True)
class Run:
    """A simulated attack.

    Attributes:
        start: Coordinates of the first pose (nq,).
        reset: The frame of the reset: what is inside something at the start.
        frames: All after it, with their substeps.
        seconds, work: What each cost: CPU time [s], and in budgets of a frame.
        memory: What stepping took [MB], where the system tells.
    """

    simulator: Simulator
    start: np.ndarray
    reset: Frame
    frames: list[Frame]
    seconds: list[float]
    work: list[float]
    memory: float | None


def simulate(attack: Attack, frames: int | None = None) -> Run:
    """Runs an attack, so many frames of it at most."""
    settings = Settings(record="substeps", **attack.settings)
    people = [body()] * len(attack.motions)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        simulator = Simulator(attack.scene, body=people, settings=settings, fps=attack.fps)
    simulator.world.stepper.keep_pieces(True)  # the judge sees every committed pose
    reset = simulator.reset([m[0] for m in attack.motions])
    start = simulator.world.stepper.qpos()  # people have been put on what is under them
    length = min(map(len, attack.motions))
    done, seconds, work, memory = [], [], [], _Memory()
    for t in range(1, length if frames is None else min(length, frames + 1)):
        poses = [m[t] for m in attack.motions]
        begin = time.thread_time()
        done.append(simulator.step(poses))
        seconds.append(time.thread_time() - begin)
        work.append(simulator.world.stepper.frame_work())
        if sum(seconds) > PATIENCE:
            break
    return Run(simulator, start, reset, done, seconds, work, memory.grown())


class _Memory:
    """Peak of the process's memory since here, where the system tells."""

    def __init__(self) -> None:
        self.before = None
        try:
            Path("/proc/self/clear_refs").write_text("5")
            self.before = self._peak()
        except OSError:
            pass

    @staticmethod
    def _peak() -> float:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return float(line.split()[1]) / 1024.0
        return 0.0

    def grown(self) -> float | None:
        """By how much it grew [MB]."""
        return None if self.before is None else self._peak() - self.before


def judged(run: Run) -> dict[str, object]:
    """Gaps of people to statics, and of all else that moves, and crossings, at every substep.

    What the run itself says to be inside something is left out while it says so, of all but the
    start's gap: such starts are judged by `campaigns.starts`. It may say so of nothing later that
    it does not say of the start.
    """
    world = run.simulator.world
    told = told_inside(world, [run.reset, *run.frames])
    people = Judge(run.simulator).judge(run.start, run.frames, told, NEAR)
    gap, pair, inside = people.gap, people.where[:2], len(people.inside)
    first = people.start
    if world.objects or len(run.simulator.bodies) > 1:
        watch = Watch(run.simulator)
        first = min(first, watch.gap(run.start, statics="things")[0])
        poses = np.concatenate([f.substeps for f in run.frames])
        gap, others, more = watch.smallest(poses, min(gap, NEAR), statics="things", told=told)
        pair, inside = others if any(others) else pair, inside + more
    return {
        "start_mm": _mm(first),
        "gap_mm": _mm(gap),
        "pair": "/".join(pair),
        "inside": inside,
        "crossed": len(people.crossed),
        "later": len(set(told) - set(told_inside(world, [run.reset]))),
    }


def _mm(x):
    return None if np.isinf(x) else 1e3 * float(x)


def run(case: Case, frames: int | None = None, judge: bool = True) -> dict[str, object]:
    """The numbers of one case."""
    attack = set_up(case)
    ran = simulate(attack, frames)
    done, seconds = ran.frames, ran.seconds
    slow = np.argsort(seconds)[::-1][:10]
    row = {
        "id": case.id,
        "family": case.family,
        "people": len(attack.motions),
        "frames": len(done),
        "poses": sum(len(f.substeps) for f in done),
        "slowest": [[float(seconds[k]), int(k) + 1] for k in slow],
        "seconds": float(sum(seconds)),
        "work": float(max(ran.work)),
        "contacts": max(int(f.diagnostics["contacts"]) for f in done),
        "planes": max(int(f.diagnostics["planes"]) for f in done),
        "lost": sum(f.lost_time for f in done) * attack.fps / len(done),
        "most_lost": max(f.lost_time for f in done) * attack.fps,
        "memory_mb": ran.memory,
        "breaches": sum(len(f.breaches) for f in done),
        "finite": all(bool(np.isfinite(f.substeps).all()) for f in done),
    }
    return {**row, **(judged(ran) if judge else {})}


def complaints(row: dict) -> list[str]:
    """Texts for each broken promise of a row."""
    out = []
    most = MOST_SECONDS[min(row["people"], 2) - 1]
    if row["slowest"][0][0] > most:
        out.append(f"frame {row['slowest'][0][1]} took {1e3 * row['slowest'][0][0]:.0f} ms")
    if row["work"] > MOST_WORK:
        out.append(f"a frame cost {row['work']:.1f} of its budgets")
    if row["memory_mb"] is not None and row["memory_mb"] > MOST_MEMORY:
        out.append(f"stepping took {row['memory_mb']:.0f} MB")
    if not row["finite"]:
        out.append("not finite")
    if "gap_mm" not in row:
        return out
    gap = row["gap_mm"]
    if gap is not None and gap < -1e3 * ROUNDING:
        told = "reported" if row["breaches"] else "UNREPORTED"
        out.append(f"{-gap:.4f} mm deep {row['pair']} at {row['inside']} poses, {told}")
    if row["crossed"] and not row["breaches"]:
        out.append(f"{row['crossed']} crossings, UNREPORTED")
    if row["later"]:
        out.append(f"{row['later']} pairs are told to be inside that started clear")
    return out


def table(rows: list[dict]) -> str:
    """A line per case, and the ten slowest frames of all."""
    lines = [
        f"{'case':24s}{'frames':>7s}{'ms max':>9s}{'mean':>8s}{'conts':>6s}{'planes':>7s}"
        f"{'lost %':>8s}{'MB':>6s}{'gap mm':>9s}{'in':>4s}{'cross':>6s}{'told':>5s}"
    ]
    for r in rows:
        gap = r.get("gap_mm")
        shown = "-" if gap is None else f"{gap:.4f}"
        memory = "-" if r["memory_mb"] is None else f"{r['memory_mb']:.0f}"
        lines.append(
            f"{r['id']:24s}{r['frames']:7d}{1e3 * r['slowest'][0][0]:9.1f}"
            f"{1e3 * r['seconds'] / r['frames']:8.2f}{r['contacts']:6d}{r['planes']:7d}"
            f"{100 * r['lost']:8.2f}{memory:>6s}{shown:>9s}"
            f"{r.get('inside', 0):4d}{r.get('crossed', 0):6d}{r['breaches']:5d}"
        )
    frames = sorted(((s, r["id"], k) for r in rows for s, k in r["slowest"]), reverse=True)
    lines += ["", "the ten slowest frames"]
    lines += [f"{1e3 * s:10.1f} ms  {name}, frame {k}" for s, name, k in frames[:10]]
    return "\n".join(lines)


def fuzz_cases(seeds: int, frames: int) -> Iterator[Case]:
    """Endlessly many; seeds take turns."""
    rng = np.random.default_rng(frames)
    names = list(FAMILIES)
    for k in itertools.count():
        for seed in range(seeds):
            yield Case(names[rng.integers(len(names))], 1000 * k + seed, fuzz=True)


def _work(task: tuple[Case, int | None, bool]) -> dict[str, object]:
    try:
        return run(*task)
    except Exception as error:
        print(f"in case {task[0].id}", file=sys.stderr)
        raise RuntimeError(f"{task[0].id}: {error!r}") from error


def campaign(cases, options) -> list[dict]:
    """Rows of the cases, those of the log first; new ones are appended to it.

    Fuzzing ends when the rows have so many frames for every seed.
    """
    log = options.log
    k, n = options.shard
    most = options.fuzz * options.seeds / n
    cases = itertools.islice(cases, k, None, n)
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    known, frames = {r["id"] for r in rows}, sum(r["frames"] for r in rows)
    tasks = ((c, options.frames, not options.no_judge) for c in cases if c.id not in known)
    pieces_of(Simulator(body=body()), "skin")  # once, not in every process
    # A process of its own for every case: its memory is what the case took.
    context = multiprocessing.get_context("fork")
    with context.Pool(options.jobs, maxtasksperchild=1) as pool, log.open("a") as out:
        while True:
            batch = list(itertools.islice(tasks, 4 * options.jobs))
            if not batch or (options.fuzz and frames >= most):
                return rows
            for row in pool.imap(_work, batch):
                rows.append(row)
                frames += row["frames"]
                out.write(json.dumps(row) + "\n")
                out.flush()
                print("\n".join([table([row]).splitlines()[1], *complaints(row)]), flush=True)


def options_of(arguments: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--families", default=",".join(FAMILIES), help="names, separated by commas")
    p.add_argument("--seeds", type=int, default=1)
    p.add_argument("--frames", type=int, help="of every case, at most")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--log", type=Path, default=Path(os.devnull), help="rows; known ones are kept")
    p.add_argument("--no-judge", action="store_true", help="time, memory and contacts alone")
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--fuzz", type=int, default=0, help="frames of every seed")
    return p.parse_args(arguments)


def main() -> None:
    options = options_of()
    body()
    if options.fuzz:
        cases = fuzz_cases(options.seeds, options.fuzz)
    else:
        names = options.families.split(",")
        cases = iter([Case(name, seed) for name in names for seed in range(options.seeds)])
    rows = campaign(cases, options)
    print()
    print(table(rows if not options.fuzz else []))
    for row in rows:
        for text in complaints(row):
            print(f"{row['id']}: {text}")
    print(
        f"{len(rows)} cases, {sum(r['frames'] for r in rows)} frames, "
        f"{sum(r['poses'] for r in rows)} committed poses"
    )


if __name__ == "__main__":
    main()
