"""Holds and drops: when people alone bear an object's weight, and how that ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.labels.event_kinds import Drop, End, Hold, Limits
from halfphysics.labels.loads import Loads, frames_in, intervals, lasts

Array = NDArray[np.float64]


def holds_and_drops(loads: Loads, limits: Limits) -> Iterator[tuple[Hold, Drop | None]]:
    """Every hold of an object, and the drop in which it ends, if it does."""
    result, fps = loads.result, loads.result.fps
    carried = (loads.people >= limits.load) & (loads.elsewhere <= limits.elsewhere)
    carried &= loads.people > 0.0  # with a limit of 0 too
    if not loads.up.any():  # without gravity: only people touch it
        carried = (loads.people > 0.0) & ~loads.touched
    held = [
        (first, last)
        for first, last in intervals(carried, frames_in(limits.gap, fps))
        if lasts(first, last, limits.hold, fps)
    ]
    for k, (first, last) in enumerate(held):
        again = held[k + 1][0] if k + 1 < len(held) else len(result)
        people, parts = loads.holders(first, last, limits.load)
        names = tuple(result.people[p].name for p in people)
        ending, fell = _ending(loads, limits, people, last, again)
        # Frame 0 has no contacts: an object that is held at frame 1 is held from the start.
        start = 0 if first == 1 else first
        hold = Hold(
            object=loads.item.name,
            people=names,
            parts=tuple(parts),
            first=start,
            last=last,
            start=start / fps,
            end=last / fps,
            ending=ending,
        )
        yield hold, None if fell is None else Drop(people=names, parts=hold.parts, **fell)


def _ending(
    loads: Loads, limits: Limits, people: list[int], last: int, again: int
) -> tuple[End, dict[str, Any] | None]:
    """How a hold ends, and its drop without the holders; `again`: first frame of the next hold."""
    frames, fps = len(loads.result), loads.result.fps
    if last == frames - 1:
        return "kept", None
    # A static or another object may touch it briefly as it leaves the hand.
    soon = min(last + frames_in(limits.gap, fps) + 2, frames)
    free = last + 1 + np.flatnonzero(~loads.touched[last + 1 : soon])
    if not len(free):
        return "placed", None
    begin = int(free[0])
    meets = begin + np.flatnonzero(loads.touched[begin:])
    landed = int(meets[0]) if len(meets) else frames
    stop = min(landed, again, frames - 1)  # last frame of the flight
    if _thrown(loads, limits, people, begin):
        return "thrown", None
    heights = loads.centre[begin - 1 : stop + 1] @ loads.up
    height = float(heights.max() - heights[-2:].min())
    if again < landed:
        return "lost", None
    if height < limits.fall:
        return ("lost" if landed == frames else "placed"), None
    met = landed < frames
    return "dropped", {
        "object": loads.item.name,
        "released": begin - 1,
        "landed": landed if met else None,
        "time": (begin - 1) / fps,
        "landing": landed / fps if met else None,
        "onto": _met(loads, landed) if met else None,
        "height": height,
        "speed": _speed(loads, landed if met else None),
    }


def _thrown(loads: Loads, limits: Limits, people: list[int], begin: int) -> bool:
    """Whether the object, free from frame `begin` on, left the hands at the speed of a throw."""
    result, up = loads.result, loads.up
    if not up.any():
        return False

    def speed(places: Array) -> Array:
        moved: Array = (places[begin] - places[begin - 1]) * result.fps
        return moved

    # Velocity at the release, half a frame before: without what gravity has added since.
    left = speed(loads.centre) - 0.5 * result.scene.gravity / result.fps
    if left @ up >= limits.throw_up:
        return True
    away = []
    for person in people:
        seen = left - speed(result.people[person].motion.translation)
        away.append(float(np.linalg.norm(seen - (seen @ up) * up)))
    return min(away) >= limits.throw_away


def _met(loads: Loads, frame: int) -> str:
    """Name of the static or object that pushes the object hardest in a frame."""
    contacts, names = loads.result.contacts, loads.result.names
    index = names.index(loads.item.name)
    now = contacts[(contacts.frame == frame) & (contacts.person < 0)]
    now = now[(now.subject == index) | (now.other == index)]
    hardest = int(now.strength.argmax())
    other = now.other[hardest]
    result: str = names[now.subject[hardest] if other == index else other]
    return result


def _speed(loads: Loads, landed: int | None) -> float:
    """Speed of the impact on the way to frame `landed`; None: speed at the end [m/s]."""
    result, gravity = loads.result, loads.result.scene.gravity
    last = len(result) - 1 if landed is None else landed - 1
    fell = (loads.centre[last] - loads.centre[last - 1]) * result.fps
    velocity = fell + 0.5 * gravity / result.fps
    squared = float(velocity @ velocity)
    if landed is not None:
        squared += 2.0 * float(gravity @ (loads.centre[landed] - loads.centre[last]))
    return float(np.sqrt(max(squared, 0.0)))
