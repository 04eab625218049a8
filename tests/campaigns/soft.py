"""Random soft scenes, judged by foreign code at every committed pose: the hard frames stay clear.

    PYTHONPATH=src:tests python -m campaigns.soft --seeds 3 --frames 100000 --log soft.jsonl
                           [--seconds 600] [--shard 0/2] [--case KIND-SEED-INDEX] [--summary]

Layers on planes, boxes, meshes and objects, stiffness over six decades, 5 mm to 30 cm thick; people
and things of 10 g to 1 t thrown at up to 20 m/s; 1 to 16 substeps a frame (`support/soft/fuzz.py`).
Distances by coal, of the frames and of the hulls of the skin; people cross no static between two
poses (`clear_judge`), nor does the centre of a thing. Everything is finite, no energy is created,
no frame of one person takes over 50 ms of CPU time. One row a case; cases that the log has are
not run again.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import coal
import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.simulation.simulator import Simulator
from support.judges.clear_judge import Judge
from support.judges.coal_scene import Watch
from support.shards import shard
from support.soft.frames import Seen, hard
from support.soft.fuzz import FASTEST, Case, set_up

#: Accuracy of coal's own distances [m].
ROUNDING = 1e-6
#: CPU time of a frame [s].
MOST_SECONDS = 0.05
#: Energy of things alone may grow by this share of the largest that they had, and by the fall of
#: one substep, which a chord of a parabola does not see.
MOST_ENERGY = 0.01
#: Nothing gets faster than this many times what was thrown: a heavy thing hits a light one.
MOST_SPEED = 4.0 * FASTEST
#: Share of the time that a case may lose beyond what it loses if everything is hard.
MOST_LOST = 0.02


def run(case: Case, judge: bool = True) -> dict:
    """The numbers of one case."""
    setup = set_up(case)
    simulator = setup.simulator
    simulator.world.stepper.keep_pieces(True)  # the judge sees every committed pose
    start = simulator.world.start(setup.poses(0))[0]
    simulator.reset(setup.poses(0))
    scene, frames, seconds, energy, pressed = simulator.world.scene, [], [], [], 0
    speeds = [0.0]
    energy.append(energy_of(simulator, scene))
    for t in range(1, setup.frames + 1):
        poses = setup.poses(t)
        begin = time.thread_time()
        frames.append(simulator.step(poses))
        seconds.append(time.thread_time() - begin)
        energy.append(energy_of(simulator, scene))
        speeds.append(speed_of(simulator))
        rows = frames[-1].soft_contacts
        pressed += rows is not None and len(rows.depth) > 0
    finite = all(bool(np.isfinite(f.substeps).all()) for f in frames)
    row = {
        "id": case.id,
        "kind": case.kind,
        "people": len(setup.motions),
        "things": len(scene.objects),
        "frames": len(frames),
        "steps": sum(len(f.substeps) for f in frames),
        "fps": setup.fps,
        "substeps": simulator.settings.substeps,
        "pressed": pressed,
        "finite": finite,
        "slowest": float(max(seconds)),
        "seconds": float(sum(seconds)),
        "gained": gained(energy, scene, simulator) if not setup.motions else 0.0,
        "fastest": float(max(speeds)),
        "lost": sum(f.lost_time for f in frames) * setup.fps / len(frames),
        "breaches": sum(len(getattr(f, "breaches", ())) for f in frames),
    }
    if row["lost"] > MOST_LOST:
        row["lost_hard"] = lost_if_hard(setup)
    if judge and finite:
        row |= judged(simulator, start, frames)
    return row


def lost_if_hard(setup) -> float:
    """Share of the time that the same case loses with hard skin among hard frames."""
    simulator = setup.simulator
    settings = replace(simulator.settings, soft_skin=False)
    scene = hard(simulator.world.scene)
    other = Simulator(scene, body=list(simulator.bodies), settings=settings, fps=setup.fps)
    other.reset(setup.poses(0))
    lost = [other.step(setup.poses(t)).lost_time for t in range(1, setup.frames + 1)]
    return float(sum(lost) * setup.fps / len(lost))


def speed_of(simulator) -> float:
    """Speed of the fastest thing [m/s]."""
    v = simulator.world.stepper.qvel()
    rates = [np.linalg.norm(v[o.dof : o.dof + 3]) for o in simulator.world.objects]
    return float(max(rates, default=0.0))


def energy_of(simulator, scene) -> float:
    """Kinetic energy and energy of height of all things [J]."""
    q, v = simulator.world.stepper.qpos(), simulator.world.stepper.qvel()
    total = 0.0
    for place in simulator.world.objects:
        thing = scene.objects[place.name]
        speed, spin = v[place.dof : place.dof + 3], v[place.dof + 3 : place.dof + 6]
        total += 0.5 * thing.mass * speed @ speed + 0.5 * spin @ np.asarray(thing.inertia) @ spin
        total -= thing.mass * q[place.qpos : place.qpos + 3] @ scene.gravity
    return float(total)


def gained(energy, scene, simulator) -> float:
    """The most that the energy was over that of the start, as a share of the energy at play."""
    if not scene.objects:
        return 0.0
    h = simulator.dt / simulator.settings.substeps
    chord = sum(o.mass for o in scene.objects.values()) * 9.81 * h * FASTEST
    over = max(energy) - energy[0] - chord
    return float(over / max(energy[0] - min(energy), 1e-9))


def judged(simulator, start, frames) -> dict:
    """Distances of the hard frames at every committed pose, and crossings."""
    seen = Seen(simulator, hard(simulator.world.scene))
    gap, pair, inside, crossed = np.inf, ("", ""), 0, []
    if seen.world.people:
        verdict = Judge(seen).judge(start, frames)
        gap, pair, inside = verdict.gap, verdict.where[:2], len(verdict.inside)
        crossed = [list(map(str, c)) for c in verdict.crossed]
    if seen.world.scene.objects:
        watch, before = Watch(seen), start
        for qpos in itertools.chain.from_iterable(f.substeps for f in frames):
            d, names = watch.gap(qpos, statics="things")
            inside += d < -ROUNDING
            if d < gap:
                gap, pair = d, names
            crossed += [[n, s, ""] for n, s in passed(watch, before, qpos)]
            before = qpos
    return {
        "gap_mm": None if np.isinf(gap) else 1e3 * float(gap),
        "pair": "/".join(pair),
        "inside": int(inside),
        "crossed": len(crossed),
        "first_crossed": crossed[0] if crossed else None,
    }


def passed(watch, before, after) -> Iterator[tuple[str, str]]:
    """Things whose centre of mass went straight through a static from one pose to the next."""
    asked = coal.CollisionRequest()
    for place in watch.simulator.world.objects:
        a, b = (q[place.qpos : place.qpos + 3] for q in (before, after))
        way = b - a
        length = np.linalg.norm(way)
        if length < 0.005:  # nothing is as thin as that
            continue
        axis = np.cross([0.0, 0.0, 1.0], way / length)
        sine, cosine = np.linalg.norm(axis), way[2] / length
        turn = np.eye(3)
        if sine > 1e-9:
            turn = rot.to_matrix(rot.exp(axis / sine * np.arctan2(sine, cosine)))
        line = coal.Capsule(1e-5, float(length))
        here = coal.Transform3s(turn, 0.5 * (a + b))
        for static in watch.statics:
            if coal.collide(line, here, *static.solid, asked, coal.CollisionResult()):
                yield place.name, static.owner


def complaints(row: dict) -> list[str]:
    """Texts for each broken promise of a row."""
    out = []
    if not row["finite"]:
        return ["not finite"]
    if row["slowest"] > MOST_SECONDS and row["people"] <= 1:
        out.append(f"a frame took {1e3 * row['slowest']:.0f} ms")
    if row["gained"] > MOST_ENERGY:
        out.append(f"energy grew by {100.0 * row['gained']:.1f} %")
    if row["fastest"] > MOST_SPEED:
        out.append(f"a thing got {row['fastest']:.0f} m/s fast")
    if row["lost"] > MOST_LOST + row.get("lost_hard", 0.0):
        lost, usual = 100.0 * row["lost"], 100.0 * row["lost_hard"]
        out.append(f"lost {lost:.1f} % of the time, {usual:.1f} % if hard")
    if row.get("gap_mm") is not None and row["gap_mm"] < -1e3 * ROUNDING:
        told = "reported" if row["breaches"] else "UNREPORTED"
        out.append(f"{-row['gap_mm']:.4f} mm in {row['pair']} at {row['inside']} poses, {told}")
    if row.get("crossed"):
        out.append(f"{row['crossed']} crossings, first {row['first_crossed']}")
    return out


def summary(rows: list[dict]) -> str:
    """A line for every kind, and the sum."""
    head = ("cases", "frames", "steps", "pressed", "inside", "cross", "gap mm", "ms max", "lost %")
    lines = [f"{'':20s}" + "".join(f"{h:>9s}" for h in head)]
    kinds = sorted({r["kind"] for r in rows})
    for name, some in [(k, [r for r in rows if r["kind"] == k]) for k in kinds] + [("all", rows)]:
        gaps = [r["gap_mm"] for r in some if r.get("gap_mm") is not None]
        frames = sum(r["frames"] for r in some)
        lines.append(
            f"{name:20s}{len(some):9d}{frames:9d}{sum(r['steps'] for r in some):9d}"
            f"{sum(r['pressed'] for r in some):9d}{sum(r.get('inside', 0) for r in some):9d}"
            f"{sum(r.get('crossed', 0) for r in some):9d}{min(gaps, default=np.inf):9.4f}"
            f"{1e3 * max((r['slowest'] for r in some), default=0.0):9.1f}"
            f"{100 * sum(r['lost'] * r['frames'] for r in some) / max(frames, 1):9.3f}"
        )
    return "\n".join(lines)


def cases(seeds: int) -> Iterator[Case]:
    """Endlessly many; seeds take turns."""
    for index in itertools.count():
        for seed in range(seeds):
            yield Case(seed, index)


def case_of(text: str) -> Case:
    """The case of an id."""
    _, seed, index = text.rsplit("-", 2)
    return Case(int(seed), int(index))


def read(log: Path) -> list[dict]:
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def campaign(options) -> list[dict]:
    """Rows of the log and new ones, until there are so many frames or the time is over."""
    rows = read(options.log)
    known, frames = {r["id"] for r in rows}, sum(r["frames"] for r in rows)
    k, n = options.shard
    end = time.monotonic() + options.seconds
    with options.log.open("a") as out:
        for number, case in enumerate(cases(options.seeds)):
            if number % n != k or case.id in known:
                continue
            if frames >= options.frames or time.monotonic() > end:
                break
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    row = run(case)
            except Exception:
                print(f"in case {case.id}", file=sys.stderr)
                raise
            rows.append(row)
            frames += row["frames"]
            out.write(json.dumps(row) + "\n")
            out.flush()
            for text in complaints(row):
                print(f"{row['id']}: {text}", flush=True)
    return rows


def options_of(arguments: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--seeds", type=int, default=3)
    p.add_argument("--frames", type=int, default=100_000, help="of all seeds together")
    p.add_argument("--log", type=Path, default=Path("soft.jsonl"), help="rows; known ones are kept")
    p.add_argument("--seconds", type=float, default=np.inf)
    p.add_argument("--shard", type=shard, default="0/1", help="k/n: every n-th case from k on")
    p.add_argument("--case", help="one case by id: its row, nothing is written")
    p.add_argument("--summary", action="store_true", help="of the log, nothing is run")
    return p.parse_args(arguments)


def main() -> None:
    options = options_of()
    if options.case:
        row = run(case_of(options.case))
        print(json.dumps(row, indent=1))
        print("\n".join(complaints(row)))
        return
    rows = read(options.log) if options.summary else campaign(options)
    print(summary(rows))
    for row in rows:
        for text in complaints(row):
            print(f"{row['id']}: {text}")


if __name__ == "__main__":
    main()
