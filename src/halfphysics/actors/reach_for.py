"""Goals of the hands: to reach for a point, and to hand something over."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from halfphysics.actors.path import Point
from halfphysics.actors.reach import PALMS
from halfphysics.actors.turns import Vec
from halfphysics.base.validation import number, shown, vector
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.actors.person import Person, Target
    from halfphysics.actors.seen import Seen

HANDS = ("left", "right")
# Who lacks more than this to a point walks there first [m]; and then stands so far from it, by the
# length of a leg, with the point so far to the side of its hand [m].
_FAR, _NEAR, _ASIDE = 0.14, 0.54, 0.12
# Who does not come to it in this time [s] steps nearer, to these distances by the length of a leg.
_TRY, _NEARER = 2.2, (0.44, 0.34)
# A point that is not reached then in this time is given up [s].
_PATIENCE = 4.0
# Speed of that walk [m/s].
_SPEED = 1.0
# Something is in a hand that is nearer than this, and out of it beyond that [m].
_TAKEN, _GIVEN = 0.14, 0.22
# How long it has to be there, or out, before the hand goes back [s].
_SETTLED = 0.35
# Where a hand is held out: ahead, to its side, and above the ground, by the length of a leg.
_OUT = (0.52, 0.1, 1.3)


def checked_target(target: object, what: str) -> Target:
    """A target, its point as a tuple.

    Raises:
        InputError: Neither a point, nor a name, nor the index of a person.
    """
    if isinstance(target, str) or (isinstance(target, int) and not isinstance(target, bool)):
        return target
    x, y, z = vector(target, what, unit="m")
    return (float(x), float(y), float(z))


def checked_hand(hand: object, what: str) -> str:
    """A hand's name.

    Raises:
        InputError: Another one.
    """
    if hand not in HANDS:
        raise InputError(f"{what}: expected 'left' or 'right', found {shown(hand)}")
    return str(hand)


@dataclass(frozen=True)
class ReachFor:
    """Bring a palm to a point; walk there first if it is far, lean and bend the knees as needed.

    What no arm reaches from there is given up after some seconds (`Person.given_up`), and so is a
    walk as by `WalkTo`.

    Attributes:
        target: A point (3,) [m], an object's name, or a person's index.
        hand: "left" or "right".
        palm: How the hand comes: its palm "in" (towards the other hand), "down" or "up".
        hold: How long the hand stays there [s].
        close: Whether the fingers close there; they stay closed until the hand reaches again.

    Raises:
        InputError: An impossible value.
    """

    target: Target
    hand: str = "right"
    palm: str = "in"
    hold: float = 0.3
    close: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "target", checked_target(self.target, "ReachFor: target"))
        checked_hand(self.hand, "ReachFor: hand")
        if self.palm not in PALMS:
            raise InputError(
                f"ReachFor: palm: expected one of {', '.join(PALMS)}, found {shown(self.palm)}"
            )
        number(self.hold, "ReachFor: hold", least=0.0, unit="s")

    def task(self) -> Reaching:
        return Reaching(self)


class Reaching:
    """`ReachFor` under way."""

    def __init__(self, goal: ReachFor) -> None:
        self._goal = goal
        self._walks: bool | None = None
        self._held, self._tried, self._nearer = 0.0, 0.0, 0
        self._back, self._short = False, False

    def go_on(self, me: Person) -> bool:
        goal = self._goal
        if self._back:
            back = me.withdrawn(goal.hand)
            if back and self._short:
                return me.give_up(f"no arm comes to {goal.target!r}")
            return back
        if me.stuck and self._walks:
            return me.give_up(me.stuck)
        at = me.point_of(goal.target)
        me.look(goal.target)
        if self._walks is None:
            self._walks = me.lacks(goal.hand, at) > _FAR
            if self._walks:
                approach(me, at, goal.hand, _NEAR * me.leg)
        if not me.arrived:
            return False
        me.reach(goal.hand, at, goal.palm)
        self._tried += me.dt
        if me.reached(goal.hand):
            if goal.close:
                me.close_hand(goal.hand)
            self._held += me.dt
        elif self._tried > _TRY and self._nearer < len(_NEARER):
            # It lacks a little: a step nearer.
            approach(me, at, goal.hand, _NEARER[self._nearer] * me.leg)
            self._nearer, self._tried = self._nearer + 1, 0.0
        if self._held > goal.hold or self._tried > goal.hold + _PATIENCE:
            me.withdraw(goal.hand)
            self._back, self._short = True, self._held <= goal.hold
        return False

    def end(self, me: Person) -> None:
        me.look(None)
        me.withdraw(self._goal.hand)
        me.stop()


def approach(me: Person, at: Vec, hand: str, ahead: float) -> None:
    """Walk to where a hand is comfortable at a point, that far ahead [m]."""
    facing = math.atan2(at[1] - me.place.y, at[0] - me.place.x)
    side = -1.0 if hand == "left" else 1.0
    aside = side * _ASIDE
    c, s = math.cos(facing), math.sin(facing)
    to = Point(at[0] - ahead * c - aside * s, at[1] - ahead * s + aside * c)
    me.walk(to, facing, _SPEED)


@dataclass(frozen=True)
class HandOver:
    """Hold a hand out until something was given or taken, then withdraw it.

    Attributes:
        give: Name of the object that is in the hand; done when it is out of it.
        take: Name of the object that is to come; done when it is in the hand, which then closes.
        to: Index of the person, or name of the object, that it faces and holds the hand out to;
            None: ahead.
        hand: "left" or "right".
        until: In place of `give` and `take`: done when this says so of what is seen.
        patience: After which it withdraws in any case [s]; the goal is given up then.

    Raises:
        InputError: An impossible value, or nothing to wait for.
    """

    give: str | None = None
    take: str | None = None
    to: int | str | None = None
    hand: str = "right"
    until: Callable[[Seen], bool] | None = None
    patience: float = 20.0

    def __post_init__(self) -> None:
        checked_hand(self.hand, "HandOver: hand")
        number(self.patience, "HandOver: patience", least=0.0, unit="s")
        if sum(what is not None for what in (self.give, self.take, self.until)) != 1:
            raise InputError(
                "HandOver: expected one of give=, take= and until=: what the hand waits for"
            )

    def task(self) -> HandingOver:
        return HandingOver(self)


class HandingOver:
    """`HandOver` under way."""

    def __init__(self, goal: HandOver) -> None:
        self._goal = goal
        self._turned = False
        self._waited, self._settled = 0.0, 0.0
        self._back, self._vain = False, False

    def go_on(self, me: Person) -> bool:
        goal = self._goal
        if self._back:
            back = me.withdrawn(goal.hand)
            if back and self._vain:
                return me.give_up(f"nothing came of it within {goal.patience:g} s")
            return back
        if goal.to is not None:
            x, y, _ = me.point_of(goal.to)
            facing = math.atan2(y - me.place.y, x - me.place.x)
            me.look(goal.to)
            if not self._turned and abs(me.turned_from(facing)) > 0.35:
                me.walk(me.place, facing, _SPEED)
            self._turned = True
        if not me.arrived:
            return False
        me.reach(goal.hand, self._point(me), "in" if goal.give is not None else "up")
        self._waited += me.dt
        happened = me.reached(goal.hand) and self._happened(me)
        self._settled = self._settled + me.dt if happened else 0.0
        if self._settled and goal.take is not None:
            me.close_hand(goal.hand)
        if self._settled > _SETTLED or self._waited > goal.patience:
            me.withdraw(goal.hand)
            self._back, self._vain = True, self._settled <= _SETTLED
        return False

    def _point(self, me: Person) -> Vec:
        """Where the hand is held out."""
        side = 1.0 if self._goal.hand == "left" else -1.0
        ahead, aside, up = (k * me.leg for k in _OUT)
        c, s = math.cos(me.heading), math.sin(me.heading)
        return (
            me.place.x + ahead * c - side * aside * s,
            me.place.y + ahead * s + side * aside * c,
            up,
        )

    def _happened(self, me: Person) -> bool:
        goal = self._goal
        if goal.until is not None:
            return goal.until(me.seen)
        name = cast("str", goal.give if goal.give is not None else goal.take)
        away = math.dist(me.point_of(name), me.palm(goal.hand))
        return away > _GIVEN if goal.give is not None else away < _TAKEN

    def end(self, me: Person) -> None:
        me.look(None)
        me.withdraw(self._goal.hand)
        me.stop()
