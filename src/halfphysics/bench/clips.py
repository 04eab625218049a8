"""Motions, body and drives of the cases."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from halfphysics import scenarios
from halfphysics.base import rotations as rot
from halfphysics.bench.record import Options
from halfphysics.body.body import Body
from halfphysics.motion.motion import Motion
from halfphysics.settings import Settings
from halfphysics.simulation.sequence import Sequence

#: The paper's substeps per frame; fixed, so that both sides do the same number.
SUBSTEPS = 8


@cache
def story() -> Sequence:
    """The demo's story: body, motion, scene."""
    return scenarios.load("doorway")


def body() -> Body:
    """The simulated body, with its parts built."""
    person = story().bodies[0] or Body.default()
    person.variant  # noqa: B018  made once, outside the clock
    return person


def clips(options: Options) -> Iterator[tuple[str, Motion]]:
    """The walk of the demo's story, and the motion of the options."""
    yield "walk", options.short(story().motions[0])
    if options.motion is not None:
        yield options.motion_name, options.short(options.motion)


def drives(substeps: int, *stiffness: float) -> Iterator[tuple[str, Settings]]:
    """Both drives at several stiffnesses: Algorithm 1 of the paper, and the time constant."""
    for k in stiffness:
        yield f"paper, stiffness {k:g}", Settings.paper(k, substeps=substeps)
    for k in stiffness:
        yield f"drive_time, stiffness {k:g}", Settings(stiffness=k, substeps=substeps)


def straight(speed: float, seconds: float, start: float, fps: float = 30.0) -> Motion:
    """A T-pose that faces +x and glides along x from x = `start` [m]."""
    frames = round(seconds * fps) + 1
    turn = rot.multiply(rot.exp([0.0, 0.0, 0.5 * np.pi]), rot.exp([0.5 * np.pi, 0.0, 0.0]))
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = rot.log(turn)
    path = np.zeros((frames, 3))
    path[:, 0] = start + speed * np.arange(frames) / fps
    return Motion(path, rotations, fps)
