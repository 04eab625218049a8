"""Goals: to be at a place, and to follow somebody."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from halfphysics.actors.path import Point
from halfphysics.base.validation import number, vector

if TYPE_CHECKING:
    from halfphysics.actors.person import Person

#: The speeds of a walk [m/s].
SLOWEST, FASTEST = 0.2, 1.8
# Who follows is told its way again where the place or the speed has changed by more [m], [m/s].
_DIFFERS = 0.1


@dataclass(frozen=True)
class WalkTo:
    """Walk to a place, around what is in the way, and stand there.

    It is given up after 10 s of waiting and trying without coming nearer (`Person.given_up`).

    Attributes:
        place: Where the pelvis is to be, nearly: the middle between the ankles (x, y) [m].
        heading: Where to face there, about z [rad], 0 along +x; None: as the way ends.
        speed: Of the walk [m/s], 0.2 to 1.8.

    Raises:
        InputError: An impossible value.
    """

    place: tuple[float, float]
    heading: float | None = None
    speed: float = 1.2

    def __post_init__(self) -> None:
        x, y = vector(self.place, "WalkTo: place", 2, unit="m")
        object.__setattr__(self, "place", (float(x), float(y)))
        if self.heading is not None:
            number(self.heading, "WalkTo: heading", unit="rad")
        number(self.speed, "WalkTo: speed", least=SLOWEST, most=FASTEST, unit="m/s")

    def task(self) -> Walking:
        return Walking(self)


class Walking:
    """`WalkTo` under way."""

    def __init__(self, goal: WalkTo) -> None:
        self._goal, self._asked = goal, False

    def go_on(self, me: Person) -> bool:
        if not self._asked:
            goal = self._goal
            me.walk(Point(*goal.place), goal.heading, goal.speed)
            self._asked = True
        return me.give_up(me.stuck) if me.stuck else me.arrived

    def end(self, me: Person) -> None:
        me.stop()


@dataclass(frozen=True)
class TurnTo:
    """Turn on the spot.

    Attributes:
        heading: To face, about z [rad], 0 along +x.

    Raises:
        InputError: No finite number.
    """

    heading: float

    def __post_init__(self) -> None:
        number(self.heading, "TurnTo: heading", unit="rad")

    def task(self) -> Turning:
        return Turning(self.heading)


class Turning:
    """`TurnTo` under way."""

    def __init__(self, heading: float) -> None:
        self._heading, self._asked = heading, False

    def go_on(self, me: Person) -> bool:
        if not self._asked:
            me.walk(me.place, self._heading, 1.0)
            self._asked = True
        return me.give_up(me.stuck) if me.stuck else me.arrived

    def end(self, me: Person) -> None:
        me.stop()


@dataclass(frozen=True)
class Follow:
    """Go after a person or an object, and stay at a distance; it ends when told.

    Attributes:
        who: Key of `Seen.others`, or name of an object.
        distance: Kept [m], at least 0.5.
        speed: Fastest [m/s].

    Raises:
        InputError: An impossible value.
    """

    who: int | str
    distance: float = 1.2
    speed: float = 1.4

    def __post_init__(self) -> None:
        number(self.distance, "Follow: distance", least=0.5, unit="m")
        number(self.speed, "Follow: speed", least=SLOWEST, most=FASTEST, unit="m/s")

    def task(self) -> Following:
        return Following(self)


class Following:
    """`Follow` under way."""

    def __init__(self, goal: Follow) -> None:
        self._goal = goal
        self._told: tuple[Point, float] | None = None

    def go_on(self, me: Person) -> bool:
        at, goal = me.point_of(self._goal.who), self._goal
        x, y = me.place
        way = math.hypot(at[0] - x, at[1] - y)
        facing = math.atan2(at[1] - y, at[0] - x)
        me.look(self._goal.who)
        if way > goal.distance + 0.25 or (way > goal.distance + 0.1 and not me.arrived):
            share = (way - goal.distance) / way
            to = Point(x + share * (at[0] - x), y + share * (at[1] - y))
            self._walk(me, to, facing, min(goal.speed, 0.5 + way - goal.distance))
        elif me.arrived and abs(me.turned_from(facing)) > 0.6:
            me.walk(me.place, facing, 1.0)
        return False

    def _walk(self, me: Person, to: Point, facing: float, speed: float) -> None:
        """Tell the way, but not in every frame: a way that is told anew is looked for anew."""
        if self._told is not None and not me.arrived:
            place, pace = self._told
            if math.dist(to, place) < _DIFFERS and abs(speed - pace) < _DIFFERS:
                return
        me.walk(to, facing, speed)
        self._told = to, speed

    def end(self, me: Person) -> None:
        me.look(None)
        me.stop()
