"""What an event is: holds, slips and drops, and the thresholds that define them."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from halfphysics.base.validation import number

#: How a hold ends: with the result ("kept"); the object stands or lies on something else
#: ("placed"); it is dropped; it is thrown; or it leaves the hands without falling far, because the
#: result ends or because it is caught ("lost").
End = Literal["kept", "placed", "dropped", "thrown", "lost"]


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Thresholds of the events.

    Attributes:
        load: Smallest sum of the sizes of people's forces on an object that carries it, as a share
            of its weight; and smallest share of that sum that makes a part one that carries. Where
            no part has that share, the strongest carries.
        elsewhere: Largest share of an object's weight that statics and other objects bear while
            it is carried.
        gap: Longest interruption that is ignored [s].
        hold: Shortest hold [s].
        slide_speed: Lowest speed along the surface at which a part slides [m/s].
        slide_load: Smallest share of an object's weight that a person bears on average during a
            slip: a person who pushes it along the floor carries no load.
        slide_time, slide: Shortest slip [s], [m].
        fall: Lowest drop [m].
        throw_up, throw_away: An object that leaves the hands at this speed upward, or sideways
            relative to the person's pelvis, is thrown [m/s].
    """

    load: float = 0.1
    elsewhere: float = 0.1
    gap: float = 0.1
    hold: float = 0.2
    slide_speed: float = 0.02
    slide_load: float = 0.05
    slide_time: float = 0.2
    slide: float = 0.01
    fall: float = 0.05
    throw_up: float = 0.5
    throw_away: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = number(getattr(self, field.name), f"Limits.{field.name}", least=0.0)
            object.__setattr__(self, field.name, value)


@dataclass(frozen=True, kw_only=True)
class Hold:
    """People alone bear an object's weight from frame `first` to `last`, inclusive.

    Attributes:
        object: Its name.
        people, parts: Names of the people who hold it, and of their parts that carry it.
        first, last: Frames.
        start, end: Their times [s].
        ending: See `End`.
    """

    object: str
    people: tuple[str, ...]
    parts: tuple[str, ...]
    first: int
    last: int
    start: float
    end: float
    ending: End


@dataclass(frozen=True, kw_only=True)
class Slip:
    """Parts of a person that bear some of an object's weight move along its surface.

    Attributes:
        object, person, parts: Names.
        first, last: Frames at the end of which it slips, inclusive.
        start, end: Times of the frame before the first, and of the last [s].
        distance: Total distance along the surface; of several parts the mean weighted by force [m].
        speed: Highest speed [m/s].
    """

    object: str
    person: str
    parts: tuple[str, ...]
    first: int
    last: int
    start: float
    end: float
    distance: float
    speed: float


@dataclass(frozen=True, kw_only=True)
class Drop:
    """An object that was carried leaves the hands and falls until it touches something.

    Attributes:
        object, people, parts: Names of the object, of the people who held it and of their parts.
        released: Last frame in which it was held.
        landed: First frame in which it touches something; None: it does not before the end.
        time, landing: Times of both [s]; None as for `landed`.
        onto: Name of the item that it touches first; None as for `landed`.
        height: Fall of its centre of mass, from its highest position to that at `landed`, or at
            the end [m].
        speed: Speed of the impact: its last speed in free fall and what gravity adds on the way to
            its position at `landed` [m/s].
    """

    object: str
    people: tuple[str, ...]
    parts: tuple[str, ...]
    released: int
    landed: int | None
    time: float
    landing: float | None
    onto: str | None
    height: float
    speed: float


@dataclass(frozen=True, kw_only=True)
class Events:
    """Holds, slips and drops of a result, each kind in order of the first frame.

    Attributes:
        holds, slips, drops: See `Hold`, `Slip`, `Drop`.
    """

    holds: tuple[Hold, ...]
    slips: tuple[Slip, ...]
    drops: tuple[Drop, ...]

    @property
    def lost(self) -> int:
        """Number of holds that end with the object dropped, thrown or lost."""
        return sum(hold.ending in ("dropped", "thrown", "lost") for hold in self.holds)

    def document(self) -> dict[str, list[dict[str, Any]]]:
        """The events as plain values for a JSON file."""
        return {
            name: [
                {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(event).items()}
                for event in getattr(self, name)
            ]
            for name in ("holds", "slips", "drops")
        }
