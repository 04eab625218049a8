"""Events: when people carried things, what slipped in their hands and what they dropped.

Of things that move freely (`Scene.add_object`): what hangs on a joint or moves as it is told has
a weight that nobody carries. World z-up or as gravity points; metres, seconds.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any, Literal

from halfphysics.base.validation import number, shown
from halfphysics.errors import InputError
from halfphysics.metrics.argument_checks import check_result
from halfphysics.scene.trajectories import KinematicObject

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: How a hold ends: with the result; its thing stands or lies on something else; it is dropped; it
#: is thrown; or it is out of the hands without having fallen far, by the result's end or because
#: it was caught.
End = Literal["kept", "placed", "dropped", "thrown", "lost"]


@dataclass(frozen=True, kw_only=True)
class Limits:
    """From where on something counts.

    Attributes:
        load: What people exert on a thing, the sizes of their forces together, to carry it, of
            its weight; and what a part exerts to be one of those that carry, of all that.
        elsewhere: What statics and other objects bear of a thing's weight at most while it is
            carried.
        gap: Shorter interruptions are none [s].
        hold: Shortest hold [s].
        slide_speed: Along the surface, to slide [m/s].
        slide_load: What a person bears of a thing's weight on average while it slips: who only
            pushes it along the floor carries no load.
        slide_time, slide: Shortest slip [s], [m].
        fall: Lowest drop [m].
        throw_up, throw_away: What leaves the hands as fast upward, or sideways as seen from the
            person's pelvis, is thrown [m/s].
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
    """A thing's weight is borne by people alone, from frame `first` to `last`, inclusive.

    Attributes:
        object: Its name.
        people, parts: Names of those who hold it, and of their parts that carry.
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
    """Parts of a person that bear some of a thing's weight move along its surface.

    Attributes:
        object, person, parts: Names.
        first, last: Frames in which it slips, inclusive: it slips on the way to each.
        start, end: Time of the frame before the first, and of the last [s].
        distance: Slid in all, along the surface: of several parts the mean by force [m].
        speed: The highest [m/s].
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
    """A thing that was carried is out of the hands and falls until it meets something.

    Attributes:
        object, people, parts: Names of it, of those who held it and of their parts.
        released: Last frame in which it was held.
        landed: First frame in which it has met something; None: not before the end.
        time, landing: Times of both [s]; None likewise.
        onto: What it met first; None likewise.
        height: How far its centre of mass fell, from its highest place to that at `landed`, or
            at the end [m].
        speed: With which it met that: what gravity makes of its last speed in free fall on the
            way to its place at `landed` [m/s].
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
    """What happened to the things that people handled, each in order of its first frame.

    Attributes:
        holds, slips, drops: See `Hold`, `Slip`, `Drop`.
    """

    holds: tuple[Hold, ...]
    slips: tuple[Slip, ...]
    drops: tuple[Drop, ...]

    @property
    def lost(self) -> int:
        """Number of grasps that were lost: dropped, thrown, or out of the hands otherwise."""
        return sum(hold.ending in ("dropped", "thrown", "lost") for hold in self.holds)

    def document(self) -> dict[str, list[dict[str, Any]]]:
        """As plain values for a JSON file."""
        return {
            name: [
                {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(event).items()}
                for event in getattr(self, name)
            ]
            for name in ("holds", "slips", "drops")
        }


def events(result: Result, limits: Limits | None = None) -> Events:
    """Holds, slips and drops of a result.

    From the contacts' impulses and the poses at the frames. A thing is *carried* in a frame in
    which people exert forces on it that are, together, a share `Limits.load` of its weight or
    more, and statics and other objects bear no more than `Limits.elsewhere` of it: a tray is
    carried, what stands on it is not. A kick is over sooner than `Limits.hold`.

    A part *slides* where it is one of those that exert the load on a thing and its surface moves
    along the thing's at the contact, both taken as rigid between two frames. The thing need not
    be carried: palms that pull at a suitcase and slide along it while it stays slip too.

    Raises:
        InputError: No result, or no limits.
        FileError: In a result from a file: a body or the scene has gone.
    """
    check_result(result)
    limits = Limits() if limits is None else limits
    if not isinstance(limits, Limits):
        raise InputError(f"limits: expected Limits, found {shown(limits)}")
    from halfphysics.labels.holds import Loads, holds_and_drops
    from halfphysics.labels.slips import slips_of

    scene = result.scene
    holds: list[Hold] = []
    drops: list[Drop] = []
    slips: list[Slip] = []
    for name in result.objects:
        item = scene.objects.get(name)  # None: a link, or its mesh has gone
        if item is None or isinstance(item, KinematicObject):
            continue
        loads = Loads.of(result, item)
        if not len(loads.rows):
            continue
        for hold, drop in holds_and_drops(loads, limits):
            holds.append(hold)
            drops += [] if drop is None else [drop]
        slips += slips_of(loads, limits)
    return Events(
        holds=tuple(sorted(holds, key=lambda hold: hold.first)),
        slips=tuple(sorted(slips, key=lambda slip: slip.first)),
        drops=tuple(sorted(drops, key=lambda drop: drop.released)),
    )
