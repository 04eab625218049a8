"""Whole calls as users make them: a clip with its set-up, and many clips at once."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from halfphysics.bench.clips import body, story, straight
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box
from halfphysics.results.result import Result
from halfphysics.scene.scene import Scene
from halfphysics.simulation.build_world import build_world
from halfphysics.simulation.simulate import follow, simulate
from halfphysics.simulation.simulate_many import simulate_many
from halfphysics.simulation.world import World

#: Clips of a batch.
CLIPS = 8


def setup(options: Options) -> Iterator[Record]:
    """A world of a body and a scene seen before."""
    person, told = body(), story()
    settings = told.settings

    def world(of: Body) -> World:
        return build_world([of], told.scene, settings)

    def again() -> World:
        return world(person)

    def anew() -> World:  # a body of the same content, of which this process keeps nothing
        return world(dataclasses.replace(person))

    yield measure("setup", "world, seen before", 1, options, ours=again, peer=anew, unit="s").record


def clip(options: Options) -> Iterator[Record]:
    """A short clip by `simulate`, set-up included, beside the same in a world built before."""
    person, told = body(), story()
    motion = options.short(told.motions[0][:151])
    kept = build_world([person], Scene(), told.settings)

    def whole() -> Result:
        return simulate(motion, body=person, settings=told.settings)

    def after() -> Result:
        return follow(kept, [motion])

    frames = len(motion) - 1
    setting = f"{frames} free frames, set-up included"
    yield measure("clip", setting, frames, options, ours=whole, peer=after).record


def batch(options: Options) -> Iterator[Record]:
    """Clips at a wall, one after the other and on threads."""
    motion = options.short(straight(1.5, 2.0, start=-0.4))
    scene = Scene()
    scene.add_static("wall", Box((0.01, 4.0, 4.0)), position=(0.5, 0.0, 0.0))
    person, jobs = body(), [motion] * CLIPS
    frames = CLIPS * (len(motion) - 1)

    def one_by_one() -> list[Result]:
        return [simulate(one, scene, body=person) for one in jobs]

    def many(threads: int) -> Callable[[], list[Result]]:
        return lambda: simulate_many(jobs, scene, body=person, threads=threads)

    for threads in (1, 2):
        setting = f"{CLIPS} clips at a wall, {threads} thread{'s' * (threads > 1)}"
        ours = many(threads)
        done = measure("batch", setting, frames, options, ours=ours, peer=one_by_one)
        times = {"by the clock [frames/s]": (_clock(ours, frames), _clock(one_by_one, frames))}
        yield replace(done.record, checks=times)


def _clock(work: Callable[[], object], frames: int) -> float:
    """Rate of a pass by the clock [frames/s]."""
    start = time.perf_counter()
    work()
    return frames / (time.perf_counter() - start)
