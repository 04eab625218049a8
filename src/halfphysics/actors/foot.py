"""A foot on the ground or between two places on it, as a function of the phase.

The phase counts steps, as in `scenarios.acting.gait`: the step that begins at phase k swings one
foot from k + d/2 to k + 1 - d/2, where d is the fraction of a step with both feet down. A foot on
the ground rolls over its heel, lies flat, and rolls over its toe joint: it never slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from halfphysics.actors.limbs import LegBones
from halfphysics.actors.turns import Quat, Vec, plus, times, wrapped
from halfphysics.scenarios.acting.gait import DOUBLE, HEEL_STRIKE, LIFT, TOE_OFF, TOES_OUT

_STRIKE, _OFF = float(HEEL_STRIKE), float(TOE_OFF)
_OUT = float(TOES_OUT)
# Phases over which a foot rolls down after its heel strikes.
_DOWN = 0.9 * DOUBLE
# How much earlier a flat foot is over its place, as a share of the swing.
_EARLY = 0.15


def ease(x: float) -> float:
    """`halfphysics.motion.easing.ease` of one number."""
    if x <= 0.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


class Foothold(NamedTuple):
    """A place of a foot: below its ankle (x, y) [m], and the heading of the person there [rad]."""

    x: float
    y: float
    yaw: float


class FootPose(NamedTuple):
    """Of one foot: position of the ankle [m] and rotation, world; the toes' bend up [rad]."""

    ankle: Vec
    turn: Quat
    bend: float


@dataclass(frozen=True)
class Foot:
    """A foot that stands, from its landing until it lifts.

    Attributes:
        hold: Where.
        strike: Phase of its landing.
        ahead: How much of a full heel strike it lands with, 0 to 1.
        off: Phase at which it begins to roll off.
        span: Phases until it is rolled off.
        behind: How much of a full roll it lifts with, 0 to 1.
    """

    hold: Foothold
    strike: float = 0.0
    ahead: float = 0.0
    off: float = 0.0
    span: float = 1.0
    behind: float = 0.0

    def pitch(self, phase: float) -> float:
        """Toes up where positive [rad]."""
        out = 0.0
        if self.ahead:
            out = _STRIKE * self.ahead * (1.0 - ease((phase - self.strike) / _DOWN))
        if self.behind:
            out -= _OFF * self.behind * ease((phase - self.off) / self.span)
        return out

    def pose(self, leg: LegBones, left: float, phase: float) -> FootPose:
        """The foot standing; `left` is 1 of a left foot, -1 of a right one."""
        pitch = self.pitch(phase)
        x, y, yaw = self.hold
        ankle, turn = leg.planted(x, y, yaw + left * _OUT, pitch)
        return FootPose(ankle, turn, max(-pitch, 0.0))


def swung(leg: LegBones, left: float, before: Foot, after: Foot, start: int, u: float) -> FootPose:
    """A foot in the step that begins at phase `start`, at u in [0, 1] of it.

    Its pose of lifting is continued into the swing, and its pose of landing back into it.
    """
    phase = start + u
    if u <= 0.5 * DOUBLE:
        return before.pose(leg, left, phase)
    if u >= 1.0 - 0.5 * DOUBLE:
        return after.pose(leg, left, phase)
    s = (u - 0.5 * DOUBLE) / (1.0 - DOUBLE)
    # A foot that lands flat is over its place before it comes down.
    t = min(1.0, s / (1.0 - _EARLY * (1.0 - after.ahead)))
    w = t * t * (3.0 - 2.0 * t)
    p0, p1 = before.pitch(phase), after.pitch(phase)
    old, new = before.hold, after.hold
    yaw = old.yaw + w * wrapped(new.yaw - old.yaw) + left * _OUT
    away, _ = leg.planted(old.x, old.y, old.yaw + left * _OUT, p0)
    to, _ = leg.planted(new.x, new.y, new.yaw + left * _OUT, p1)
    _, turn = leg.planted(0.0, 0.0, yaw, (1.0 - w) * p0 + w * p1)
    ankle = plus(times(away, 1.0 - w), to, w)
    # Up quickly, so that the toes do not scuff, and down smoothly.
    rise = LIFT * 6.75 * s * (1.0 - s) * (1.0 - s)
    return FootPose(
        (ankle[0], ankle[1], ankle[2] + rise), turn, (1.0 - ease(2.2 * s)) * max(-p0, 0.0)
    )
