"""Goals: to sit down, and to stand up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from halfphysics.actors.path import Point
from halfphysics.actors.seat import feet_before, seat_pelvis
from halfphysics.base.validation import number, vector

if TYPE_CHECKING:
    from halfphysics.actors.person import Person

_SPEED = 1.0
# A body this far from where it is to sit is not on the seat [m]; after so long it is given up [s].
_OFF, _PATIENCE = 0.1, 1.0


@dataclass(frozen=True)
class SitOn:
    """Walk to a seat, sit down and stay for a time.

    A seat that it cannot walk to is given up, as by `WalkTo`; and so is one on which its body does
    not come to rest within 0.1 m of the place, such as one that is too high for it.

    Attributes:
        place: Where the pelvis rests on it (x, y) [m].
        height: Of the seat [m], 0.3 to 0.7.
        heading: Where a person who sits there faces, about z [rad].
        stay: How long it sits [s].

    Raises:
        InputError: An impossible value.
    """

    place: tuple[float, float]
    height: float = 0.45
    heading: float = 0.0
    stay: float = 2.0

    def __post_init__(self) -> None:
        x, y = vector(self.place, "SitOn: place", 2, unit="m")
        object.__setattr__(self, "place", (float(x), float(y)))
        number(self.height, "SitOn: height", least=0.3, most=0.7, unit="m")
        number(self.heading, "SitOn: heading", unit="rad")
        number(self.stay, "SitOn: stay", least=0.0, unit="s")

    def task(self) -> Sitting:
        return Sitting(self)


class Sitting:
    """`SitOn` under way. It does not stand up at its end: what comes next makes it."""

    def __init__(self, goal: SitOn) -> None:
        self._goal = goal
        self._walks, self._sits = False, False
        self._sat, self._missed = 0.0, 0.0

    def go_on(self, me: Person) -> bool:
        goal = self._goal
        if not self._walks:
            to = feet_before(goal.place, goal.heading, me.leg)
            me.walk(Point(*to), goal.heading, _SPEED)
            self._walks = True
        if not self._sits and me.stuck:
            return me.give_up(me.stuck)
        if not self._sits and me.arrived and me.stands:
            me.sit(seat_pelvis(goal.place, goal.height, me.leg))
            self._sits = True
        return self._sits and me.sits and self._is_done(me)

    def _is_done(self, me: Person) -> bool:
        """Of who sits, as far as its reference goes."""
        goal = self._goal
        if me.away > _OFF:
            self._missed += me.dt
            if self._missed > _PATIENCE:
                me.rise()
                x, y = goal.place
                return me.give_up(f"({x:g}, {y:g}) was not sat on: the body is {me.away:.2f} m off")
            return False
        self._missed = 0.0
        self._sat += me.dt
        return self._sat >= goal.stay

    def end(self, me: Person) -> None:
        me.stop()


@dataclass(frozen=True)
class StandUp:
    """Stand up from where it sits."""

    def task(self) -> StandingUp:
        return StandingUp()


class StandingUp:
    """`StandUp` under way."""

    def go_on(self, me: Person) -> bool:
        me.rise()
        return me.stands

    def end(self, me: Person) -> None:
        """Nothing was asked that goes on."""
