"""Sitting on a soft sofa and lying on a mattress, beside the same motion on rigid ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from halfphysics import scenarios
from halfphysics.bench.clips import SUBSTEPS, body
from halfphysics.bench.record import Checks, Options, Record
from halfphysics.bench.sides import followed, measure
from halfphysics.results.result import Result
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence
from halfphysics.simulation.simulator import Simulator

#: Scenario, and the material of its furniture.
SEAT = ("sit_on_sofa", "sofa")
BED = ("stretch_on_bed", "mattress")
#: Frames of a quick run: the last of the way down, and seated; lying. Their first is clear.
_SEATED, _LYING = slice(35, 65), slice(15, 45)


def seat(options: Options) -> Iterator[Record]:
    """The scenario `sit_on_sofa` with a soft seat and rest."""
    yield from _beside("soft-seat", SEAT, _SEATED, options)


def bed(options: Options) -> Iterator[Record]:
    """The scenario `stretch_on_bed` on a soft mattress."""
    yield from _beside("soft-bed", BED, _LYING, options)


def _beside(case: str, what: tuple[str, str], quick: slice, options: Options) -> Iterator[Record]:
    name = what[0]
    told = scenarios.load(name, body=body())
    motion = told.motions[0][quick] if options.quick else told.motions[0]
    settings = Settings(substeps=SUBSTEPS)
    soft, hard = (
        Simulator(scene, body=body(), settings=settings, fps=motion.fps)
        for scene in (story(what).scene, told.scene)
    )
    done = measure(
        case,
        f"{name}, N={SUBSTEPS}",
        len(motion) - 1,
        options,
        ours=followed(soft, motion),
        peer=followed(hard, motion),
    )
    checks: Checks = {
        "time lost [ms]": (
            1000.0 * float(done.ours.lost_time.sum()),
            1000.0 * float(done.peer.lost_time.sum()),
        ),
        **pressing(done.ours),
    }
    yield replace(done.record, checks=checks)


def story(what: tuple[str, str]) -> Sequence:
    """A scenario with soft furniture."""
    name, material = what
    return scenarios.load(name, body=body(), soft=material)


def pressing(result: Result) -> Checks:
    """Frames in which something soft is pressed, and the last frame's load and peak pressure."""
    rows = result.soft_contacts
    if rows is None:
        return {}
    last = rows.frame == len(result) - 1
    load = float((rows.pressure * rows.area)[last].sum())
    return {
        "frames pressed": (float(len(np.unique(rows.frame))), None),
        "load at the end [N]": (load, None),
        "peak at the end [kPa]": (0.001 * float(rows.pressure[last].max(initial=0.0)), None),
    }
