"""Scenario: two people who walk into each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base.validation import number
from halfphysics.scenarios.acting.gait import walk
from halfphysics.scenarios.acting.walk_plan import Walk
from halfphysics.scenarios.props import stage
from halfphysics.simulation.sequence import Sequence

if TYPE_CHECKING:
    from halfphysics.body.body import Body

#: How far apart they start, and how far each wants to go [m]: past each other.
APART, DISTANCE = 4.0, 3.0


def build(
    *,
    fps: float = 30.0,
    speed: float = 1.5,
    offset: float = 0.0,
    stature: float = 1.60,
    body: Body | None = None,
    other: Body | None = None,
) -> Sequence:
    """Two people walk into each other head-on, which their motions alone would walk through.

    Args:
        fps: Frames per second.
        speed: Of both walks [m/s].
        offset: Of one path beside the other [m]; from 0.1 they brush past, from 0.8 untouched.
        stature: Of the second person [m].
        body: The first person; None: the default body.
        other: The second person; None: the default body of that stature.
    """
    offset = number(offset, "offset", least=-2.0, most=2.0, unit="m")
    first, second = stage.actor(body), stage.partner(other, stature)
    here = Walk(distance=DISTANCE, speed=speed)
    there = Walk(distance=DISTANCE, speed=speed, start=(APART, offset), heading=np.pi)
    motions = (walk(first, here, fps), walk(second, there, fps))
    return Sequence(motions, stage.floor(), (first, second))
