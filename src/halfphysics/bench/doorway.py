"""The demo's story, as a user runs it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from halfphysics.bench.clips import body, story
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure, simulators
from halfphysics.results.result import Result
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import follow, simulate
from halfphysics.simulation.simulator import Simulator


def doorway(options: Options) -> Iterator[Record]:
    """The story with and without the set-up of `simulate` before the first frame."""
    person, told = body(), story()
    motion = options.short(told.motions[0])
    settings = told.settings
    frames = len(motion) - 1
    skin, parts = simulators(person, settings, motion.fps, told.scene)

    def whole(by: Settings) -> Callable[[], Result]:
        return lambda: simulate(motion, told.scene, body=person, settings=by)

    def after(simulator: Simulator) -> Callable[[], Result]:
        return lambda: follow(simulator.world, [motion])

    for setting, ours, rigid in (
        ("simulate(), set-up included", whole(skin.settings), whole(parts.settings)),
        ("without set-up", after(skin), after(parts)),
    ):
        done = measure("doorway", setting, frames, options, ours=ours, parts=rigid)
        result = done.ours
        yield replace(
            done.record,
            checks={
                "smallest clearance [mm]": (1000.0 * float(result.clearance.min()), None),
                "time lost [ms]": (1000.0 * float(result.lost_time.sum()), None),
            },
        )
