"""One step: the pelvis between two knots, and what a person does above its feet meanwhile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from halfphysics.actors.foot import Foot, Foothold, FootPose, ease
from halfphysics.actors.turns import Quat, Vec, plus, wrapped
from halfphysics.scenarios.acting import posture
from halfphysics.scenarios.acting.walk_plan import WALK_RATIO

#: Side -> its sign along the person's left.
SIGN = {"left": 1.0, "right": -1.0}

#: Length of a step at the usual speed [m]: amplitudes go with the square of a step's length.
USUAL_STEP = math.sqrt(WALK_RATIO * posture.USUAL)
_ARCH = 7.0**7 / (3.0**3 * 4.0**4)
# Weight shift of a step on the spot, towards the standing foot [m].
_SHIFT = 0.03


class Stride(NamedTuple):
    """What a person does above its feet: amplitude of the walk, and its two phases.

    Attributes:
        going: 0 standing, 1 walking at the usual speed.
        ahead: 1 with the left foot in front, -1 with the right one.
        swings: 1 in the middle of a left step, -1 in the middle of a right one.
    """

    going: float
    ahead: float
    swings: float


class Stand(NamedTuple):
    """Pelvis and feet at one moment, world.

    Attributes:
        pelvis: Position of the pelvis joint [m].
        root: Its rotation.
        yaw: Heading of the person [rad].
        feet: Left and right foot.
        stride: Of arms and trunk.
    """

    pelvis: Vec
    root: Quat
    yaw: float
    feet: tuple[FootPose, FootPose]
    stride: Stride


@dataclass
class Knot:
    """The pelvis where both feet are down.

    Attributes:
        at: Middle of the feet (x, y) [m], and heading [rad].
        rate: Change of these by phase.
        height: Of the pelvis joint [m].
        going: As of `Stride`.
    """

    at: Vec
    rate: Vec = (0.0, 0.0, 0.0)
    height: float = 0.0
    going: float = 0.0


@dataclass
class Step:
    """One step under way.

    Attributes:
        side: The foot that swings.
        start: Phase at which it begins.
        before, after: That foot as it stood, and as it will stand.
        first, last: The pelvis at its begin and at its end.
        bump: How far the pelvis rises in between [m].
    """

    side: str
    start: int
    before: Foot
    after: Foot
    first: Knot
    last: Knot
    bump: float = 0.0


def arch(u: float) -> float:
    """The pelvis's rise in a step: 1 at its highest, early, since a leg that swings to its landing
    pulls the pelvis down.
    """
    v = max(0.0, 1.0 - u)
    return _ARCH * u * u * u * v * v * v * v


def share(distance: float) -> float:
    """Of a full heel strike or roll, for a foot that far ahead or behind [m]."""
    return min(max(distance / (0.5 * USUAL_STEP), 0.0), 1.0)


def middle(a: Foothold, b: Foothold) -> Vec:
    return (0.5 * (a.x + b.x), 0.5 * (a.y + b.y), a.yaw + 0.5 * wrapped(b.yaw - a.yaw))


def near(at: Vec, to: Vec) -> Vec:
    """The same place, its heading within half a turn of that of `to`."""
    return (at[0], at[1], to[2] + wrapped(at[2] - to[2]))


def between(first: Knot, last: Knot, u: float) -> Vec:
    """The quintic with no acceleration at its ends; beyond its end it goes on evenly."""
    if u >= 1.0:
        return plus(last.at, last.rate, u - 1.0)
    e, cube = ease(u), u * u * u
    a = u - cube * (6.0 - u * (8.0 - 3.0 * u))
    b = cube * (-4.0 + u * (7.0 - 3.0 * u))
    return tuple(  # type: ignore[return-value]
        p + e * (q - p) + a * v + b * w
        for p, v, q, w in zip(first.at, first.rate, last.at, last.rate, strict=True)
    )


def stride_of(step: Step, u: float) -> tuple[Stride, float]:
    """Amplitude and phases of a step, and the shift of weight to the left [m]."""
    left = SIGN[step.side]
    going = step.first.going + ease(u) * (step.last.going - step.first.going)
    c, s = math.cos(math.pi * u), math.sin(math.pi * u)
    shift = -left * _SHIFT * max(0.0, 1.0 - going) * s * s
    return Stride(going, -left * c, left * s), shift
