"""Which foot goes next, and where to: steps along a path, on the spot, and to a stand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from halfphysics.actors.foot import Foothold
from halfphysics.actors.path import Path
from halfphysics.actors.stride import SIGN
from halfphysics.actors.turns import wrapped
from halfphysics.actors.walker import OTHER, SIDES, Walker
from halfphysics.scenarios.acting.walk_plan import WALK_RATIO

# Farthest that a foot turns from the other one [rad]: walking, and on the spot.
_TURN_WALKING, _TURN_ON_SPOT = 0.55, 0.85
# Beyond this the person turns on the spot before it goes on [rad].
_SHARP = 1.0
# A path shorter than this is gone by side steps, whatever its direction [m].
_SHUFFLE = 0.35
# The longest step to the side or back [m].
_SIDEWAYS = 0.4
# Time of a step on the spot, and of the shortest step [s].
_SLOW, _QUICK = 0.58, 0.4
# The first step of a walk, as a share of an ordinary one.
_FIRST = 0.75
# Feet nearer than this to where they should be are there [m], [rad].
_THERE, _FACING = 1e-3, 2e-3
# Length of the default body's leg [m]: steps are as much longer as legs are.
_LEG = 0.86


@dataclass(frozen=True)
class Aim:
    """Where a walk goes.

    Attributes:
        path: To the place.
        heading: To face there, about z [rad]; None: as the path ends.
        speed: Of the walk [m/s].
        catching: Whether it keeps its balance: short quick steps, without turning to the way.
    """

    path: Path
    heading: float | None = None
    speed: float = 1.2
    catching: bool = False


class Next(NamedTuple):
    """Arguments of `Walker.step`."""

    side: str
    to: Foothold
    then: Foothold | None
    seconds: float


def step_length(walker: Walker, speed: float) -> float:
    """Of an ordinary step [m]: people keep the ratio of length and frequency."""
    return math.sqrt(WALK_RATIO * speed) * walker.legs["left"].length / _LEG


def stopping(walker: Walker) -> Next | None:
    """The step after which the person stands; None: it stands."""
    if not walker.moving and _beside(walker):
        return None
    side = OTHER[walker.last_side]
    at = _centre_line(walker, OTHER[side])
    return Next(side, walker.placed(at, side), None, 0.5)


def next_step(walker: Walker, aim: Aim) -> Next | None:
    """The next step of a person whose feet are both down; None: it is there and stands."""
    goal = Foothold(*aim.path.end, _final_heading(walker, aim))
    here = {side: _centre_line(walker, side) for side in SIDES}
    if not walker.moving and all(_at(here[side], goal) for side in SIDES):
        return None
    side = OTHER[walker.last_side] if walker.moving else _first(walker, aim, goal, here)
    plan = _Plan(walker, aim, goal)
    to, turned = plan.after(here[OTHER[side]], here[side], first=not walker.moving)
    then, _ = plan.after(to, here[OTHER[side]])
    stands = _at(to, goal) and _at(here[OTHER[side]], goal)
    length = math.hypot(to.x - here[OTHER[side]].x, to.y - here[OTHER[side]].y)
    seconds = plan.seconds(length)
    if turned:
        seconds = _QUICK if aim.catching else _SLOW
    other = OTHER[side]
    return Next(
        side, walker.placed(to, side), None if stands else walker.placed(then, other), seconds
    )


class _Plan:
    def __init__(self, walker: Walker, aim: Aim, goal: Foothold) -> None:
        self.aim, self.goal = aim, goal
        self.length = step_length(walker, aim.speed)
        self.shuffles = aim.catching or aim.path.length < _SHUFFLE

    def seconds(self, length: float) -> float:
        usual = self.length / self.aim.speed
        return max(_QUICK, min(usual, 0.9)) if length > 0.5 * self.length else max(usual, 0.5)

    def after(
        self, support: Foothold, swinging: Foothold, *, first: bool = False
    ) -> tuple[Foothold, bool]:
        """Where the person would stand if both feet were down after a step; whether on the spot.

        Args:
            support: The same, by the foot that stands.
            swinging: The same, by the foot that lifts.
            first: Whether the walk begins.
        """
        path, goal = self.aim.path, self.goal
        if self.shuffles:
            way = math.hypot(goal.x - support.x, goal.y - support.y)
            share = min(1.0, _SIDEWAYS / way) if way > 0.0 else 1.0
            x, y = (
                support.x + share * (goal.x - support.x),
                support.y + share * (goal.y - support.y),
            )
            return self._limited(Foothold(x, y, goal.yaw), support, _TURN_ON_SPOT), True
        s = path.nearest(support.x, support.y)
        rest = path.length - s
        if rest < 0.02:
            return self._limited(goal, support, _TURN_ON_SPOT), True
        ahead = path.heading(min(s + 0.3, path.length))
        turn = wrapped((support.yaw if ahead is None else ahead) - support.yaw)
        if abs(turn) > _SHARP:
            x, y = 0.5 * (support.x + swinging.x), 0.5 * (support.y + swinging.y)
            yaw = support.yaw + math.copysign(min(abs(turn), _TURN_ON_SPOT), turn)
            return Foothold(x, y, yaw), True
        length = self.length * (_FIRST if first else 1.0) * (1.0 - 0.35 * abs(turn) / _SHARP)
        step = rest / max(1, math.ceil(rest / length - 0.1)) if rest < 2.5 * length else length
        at = path.at(s + step)
        if step >= rest - 1e-6:
            return self._limited(goal, support, _TURN_WALKING), False
        facing = path.heading(s + step)
        return self._limited(
            Foothold(at.x, at.y, support.yaw if facing is None else facing), support, _TURN_WALKING
        ), False

    def _limited(self, at: Foothold, support: Foothold, most: float) -> Foothold:
        turn = wrapped(at.yaw - support.yaw)
        return Foothold(at.x, at.y, support.yaw + min(max(turn, -most), most))


def _final_heading(walker: Walker, aim: Aim) -> float:
    if aim.heading is not None:
        return aim.heading
    end = aim.path.heading(aim.path.length)
    return walker.centre.yaw if end is None or aim.path.length < _SHUFFLE else end


def _first(walker: Walker, aim: Aim, goal: Foothold, here: dict[str, Foothold]) -> str:
    """The foot that begins: that on the side to which the person turns, or goes sideways."""
    yaw = walker.centre.yaw
    if aim.path.length >= _SHUFFLE and not aim.catching:
        ahead = aim.path.heading(0.3)
        turn = wrapped((yaw if ahead is None else ahead) - yaw)
        if abs(turn) > 0.2:
            return "left" if turn > 0.0 else "right"
        return OTHER[walker.last_side]
    undone = [side for side in SIDES if not _at(here[side], goal)]
    if len(undone) == 1:
        return undone[0]
    turn = wrapped(goal.yaw - yaw)
    if abs(turn) > 0.2:
        return "left" if turn > 0.0 else "right"
    end = aim.path.end
    aside = math.cos(yaw) * (end.y - walker.centre.y) - math.sin(yaw) * (end.x - walker.centre.x)
    return "left" if aside > 0.0 else "right"


def _centre_line(walker: Walker, side: str) -> Foothold:
    """Where the person would stand if both feet were as this one is."""
    hold, w = walker.hold(side), SIGN[side] * walker.width
    return Foothold(hold.x + w * math.sin(hold.yaw), hold.y - w * math.cos(hold.yaw), hold.yaw)


def _beside(walker: Walker) -> bool:
    return _at(_centre_line(walker, "left"), _centre_line(walker, "right"))


def _at(at: Foothold, goal: Foothold) -> bool:
    near = math.hypot(at.x - goal.x, at.y - goal.y) < _THERE
    return near and abs(wrapped(at.yaw - goal.yaw)) < _FACING
