"""Two people who walk into each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from halfphysics import scenarios
from halfphysics.bench.clips import SUBSTEPS, body, drives
from halfphysics.bench.record import Options, Record
from halfphysics.bench.sides import measure
from halfphysics.motion.motion import Motion
from halfphysics.results.result import Result
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence
from halfphysics.simulation.simulate import follow
from halfphysics.simulation.simulator import Simulator

#: Frames of a quick run: they meet in frame 27.
_QUICK = slice(20, 45)


def meeting(options: Options) -> Iterator[Record]:
    """The scenario `meet`, both drives at stiffness 1; there is no peer for two people."""
    told = scenarios.load("meet", body=body())
    motions = [m[_QUICK] for m in told.motions] if options.quick else list(told.motions)
    for label, settings in drives(SUBSTEPS, 1.0):
        ours, parts = (
            _side(told, motions, replace(settings, contact=contact))
            for contact in ("skin", "parts")
        )
        done = measure(
            "meeting",
            f"N={SUBSTEPS}, {label}",
            len(motions[0]) - 1,
            options,
            ours=ours,
            parts=parts,
        )
        contacts = done.ours.contacts
        yield replace(
            done.record,
            checks={
                "frames in contact": (float(len(np.unique(contacts.frame))), None),
                "time lost [ms]": (1000.0 * float(done.ours.lost_time.sum()), None),
            },
        )


def _side(told: Sequence, motions: list[Motion], settings: Settings) -> Callable[[], Result]:
    simulator = Simulator(
        told.scene,
        body=[person or body() for person in told.bodies],
        settings=settings,
        fps=motions[0].fps,
    )
    return lambda: follow(simulator.world, motions)
