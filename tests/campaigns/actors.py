"""What an actor costs a frame: processor time of a person by what it does, of clips and mixes.

PYTHONPATH=src:tests python -m campaigns.actors --frames 3000
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import numpy as np

import halfphysics as hp
from halfphysics.actors import Clip, Mixed, Person, ReachFor, Seen, SitOn, Wait, WalkTo

#: The limit of the mean [ms]: 2,000 environment steps a second leave 0.5 ms of two cores each.
LIMIT = 0.3
DT = 1.0 / 30.0


def cases(body: hp.Body) -> dict[str, Callable[[], hp.actors.Actor]]:
    """Name -> a new actor that goes on for ever."""
    walk = hp.scenarios.load("walk_into_wall").motion[20:80]
    round_trip = [WalkTo((3.0, 0.0)), WalkTo((0.0, 0.0))]
    return {
        "stands": lambda: Person(body, goals=[Wait(1e9)]),
        "walks": lambda: Person(body, goals=round_trip * 500),
        "reaches": lambda: Person(body, goals=[ReachFor((0.5, -0.1, 1.2), hold=1e9)]),
        "sits": lambda: Person(body, goals=[SitOn((-0.4, 0.0), stay=1e9)]),
        "clip": lambda: Clip(walk, body, loop=True),
        "mixed": lambda: Mixed(body, {"walk": Clip(walk, body, loop=True)}),
    }


def cost(actor: hp.actors.Actor, frames: int) -> float:
    """Mean processor time of a frame [ms]."""
    seen = Seen()
    pose = actor.reset(0)
    start = time.process_time()
    for _ in range(frames):
        pose = actor.next(DT, seen)
    spent = time.process_time() - start
    assert np.isfinite(pose.rotations).all()
    return 1e3 * spent / frames


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=3000)
    frames = parser.parse_args().frames
    worst = 0.0
    for name, make in cases(hp.Body.default()).items():
        took = cost(make(), frames)
        worst = max(worst, took)
        print(f"{name:8s} {took:.3f} ms a frame")
    print(f"worst {worst:.3f} ms, limit {LIMIT} ms: {'held' if worst < LIMIT else 'MISSED'}")
    assert math.isfinite(worst)


if __name__ == "__main__":
    main()
