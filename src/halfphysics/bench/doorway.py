"""The demo's story, as a user runs it."""

from __future__ import annotations

from collections.abc import Iterator

from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.bench.timing import alone
from halfphysics.simulation import follow, simulate
from halfphysics.simulator import Simulator


def doorway(options: Options) -> Iterator[Record]:
    """With and without what `simulate` does before the first frame."""
    who, told = body(), story()
    motion = options.short(told.motion)
    settings = told.settings
    frames = len(motion) - 1
    simulator = Simulator(told.scene, body=who, settings=settings, fps=motion.fps)
    for setting, work in (
        (
            "simulate(), set-up included",
            lambda: simulate(motion, told.scene, body=who, settings=settings),
        ),
        ("without set-up", lambda: follow(simulator, [motion])),
    ):
        timing = alone(work, options)
        result = timing.result
        yield Record(
            case="doorway",
            setting=setting,
            frames=frames,
            ours=timing.rates(frames),
            checks={
                "smallest clearance [mm]": (1000.0 * float(result.clearance.min()), None),
                "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
            },
        )
