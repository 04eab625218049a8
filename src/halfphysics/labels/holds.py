"""Holds and drops: who bears an object's weight, and what becomes of it when nobody does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.labels.events import Drop, End, Hold, Limits
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.scene.items import Object

Array = NDArray[np.float64]
Frames = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Loads:
    """What people, and everything else, exert on one object.

    Attributes:
        result, thing: What happened, to what.
        rows: Of ``result.contacts``: where people push it (k,), ordered by frame.
        share: Size of the impulse of each of those, of the object's weight over a frame (k,).
        people: Sum of those over everybody (T,).
        elsewhere: What statics and other objects bear of its weight (T,): upward impulses.
        touched: Frames (T,) in which statics or other objects push it at all.
        up: Unit vector against gravity (3,), zero without gravity.
        centre: Of mass (T, 3) [m].
    """

    result: Result
    item: Object
    rows: Frames
    share: Array
    people: Array
    elsewhere: Array
    touched: Mask
    up: Array
    centre: Array

    @classmethod
    def of(cls, result: Result, item: Object) -> Loads:
        """Those of an object of the result's scene."""
        contacts, index = result.contacts, result.names.index(item.name)
        gravity = np.asarray(result.scene.gravity)
        g = float(np.linalg.norm(gravity))
        up = -gravity / g if g else np.zeros(3)
        # Without gravity there is no weight: what touches bears all there is.
        weight = item.mass * g / result.fps
        strength = contacts.strength
        pushed = (contacts.person >= 0) & (contacts.other == index) & (strength > 0.0)
        rows = np.flatnonzero(pushed)
        share = strength[rows] / weight if weight else np.full(len(rows), np.inf)

        def per_frame(rows: Frames, values: Array) -> Array:
            return summed(contacts.frame[rows], values, len(result))

        elsewhere, touched = np.zeros(len(result)), np.zeros(len(result), dtype=bool)
        by_object = (contacts.subject >= 0) & (contacts.other == index)
        for chosen, sign in ((contacts.subject == index, 1.0), (by_object, -1.0)):
            at = np.flatnonzero(chosen & (strength > 0.0))
            touched[contacts.frame[at]] = True
            lift = np.maximum(sign * (contacts.impulse[at] @ up), 0.0)
            elsewhere += per_frame(at, lift / weight if weight else np.full(len(at), np.inf))
        track = result.objects[item.name]
        turn = rot.normalize(track.quaternion)
        arm = np.broadcast_to(item.com, track.position.shape)
        return cls(
            result=result,
            item=item,
            rows=rows,
            share=share,
            people=per_frame(rows, share),
            elsewhere=elsewhere,
            touched=touched,
            up=up,
            centre=track.position + rot.rotate(turn, arm),
        )

    def lifted(self, person: int) -> Array:
        """What a person bears of its weight (T,): upward, without gravity as what they exert."""
        contacts = self.result.contacts
        own = contacts.person[self.rows] == person
        rows, values = self.rows[own], self.share[own]
        if self.up.any():
            values = -(contacts.impulse[rows] @ self.up) * values / contacts.strength[rows]
        return summed(contacts.frame[rows], values, len(self.result))

    def holders(self, first: int, last: int, load: float) -> tuple[list[int], list[str]]:
        """People (indices) and parts (names) that push with a share of what all do together."""
        contacts = self.result.contacts
        frame = contacts.frame[self.rows]
        within = (frame >= first) & (frame <= last)
        pairs, place = np.unique(
            np.stack([contacts.person, contacts.part])[:, self.rows[within]],
            axis=1,
            return_inverse=True,
        )
        total = summed(place.reshape(-1), contacts.strength[self.rows[within]], pairs.shape[1])
        carry = pairs[:, total >= load * total.sum()]
        return sorted(set(carry[0].tolist())), [JOINT_NAMES[p] for p in sorted(set(carry[1]))]


def summed(frame: Frames, values: Array, frames: int) -> Array:
    """Sums (T,) of values (k,) by their frame (k,)."""
    return np.bincount(frame, weights=values, minlength=frames).astype(np.float64, copy=False)


def intervals(on: Mask, gap: int = 0) -> list[tuple[int, int]]:
    """First and last frame of every run of True, those at most `gap` frames apart joined."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(np.int8)))
    found: list[tuple[int, int]] = []
    for first, after in edges.reshape(-1, 2).tolist():
        if found and first - found[-1][1] - 1 <= gap:
            found[-1] = (found[-1][0], after - 1)
        else:
            found.append((first, after - 1))
    return found


def frames_in(seconds: float, fps: float) -> int:
    """Whole frames that so much time takes; a rounding error is not a frame."""
    return int(np.floor(seconds * fps + 1e-6))


def lasts(first: int, last: int, seconds: float, fps: float) -> bool:
    """Whether what is seen in frames `first` to `last`, inclusive, takes so long [s].

    One moment can be in two frames, just before the end of one and just after: at a low frame rate
    these two are long, and what they show is a kick all the same. Three are not one moment.
    """
    frames = last - first + 1
    return frames >= seconds * fps - 1e-6 and (frames > 2 or seconds == 0.0)


def holds_and_drops(loads: Loads, limits: Limits) -> Iterator[tuple[Hold, Drop | None]]:
    """Every hold of an object, and the drop that it ended in."""
    result, fps = loads.result, loads.result.fps
    carried = (loads.people >= limits.load) & (loads.elsewhere <= limits.elsewhere)
    if not loads.up.any():  # without gravity: what only people touch
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
        # No contact leads to frame 0: what is held on the way to frame 1 is held from the start.
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
    """What a hold ends in, and its drop less who held; `again`: the next hold's first frame."""
    frames, fps = len(loads.result), loads.result.fps
    if last == frames - 1:
        return "kept", None
    # Something may brush past it as it leaves the hand.
    soon = min(last + frames_in(limits.gap, fps) + 2, frames)
    free = last + 1 + np.flatnonzero(~loads.touched[last + 1 : soon])
    if not len(free):
        return "placed", None
    begin = int(free[0])
    meets = begin + np.flatnonzero(loads.touched[begin:])
    landed = int(meets[0]) if len(meets) else frames
    stop = min(landed, again, frames - 1)  # frame in which the flight is over, or the last one
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
    """Whether what is free from frame `begin` on left faster than what is let go."""
    result, up = loads.result, loads.up
    if not up.any():
        return False

    def speed(places: Array) -> Array:
        moved: Array = (places[begin] - places[begin - 1]) * result.fps
        return moved

    # At its release, half a frame before: gravity has made it slower or faster since.
    left = speed(loads.centre) - 0.5 * result.scene.gravity / result.fps
    if left @ up >= limits.throw_up:
        return True
    away = []
    for person in people:
        seen = left - speed(result.people[person].motion.translation)
        away.append(float(np.linalg.norm(seen - (seen @ up) * up)))
    return min(away) >= limits.throw_away


def _met(loads: Loads, frame: int) -> str:
    """Name of the static or object that pushes it hardest in a frame."""
    contacts, names = loads.result.contacts, loads.result.names
    index = names.index(loads.item.name)
    now = contacts[(contacts.frame == frame) & (contacts.person < 0)]
    now = now[(now.subject == index) | (now.other == index)]
    hardest = int(now.strength.argmax())
    other = now.other[hardest]
    result: str = names[now.subject[hardest] if other == index else other]
    return result


def _speed(loads: Loads, landed: int | None) -> float:
    """With which it meets something on the way to frame `landed`; None: that at the end [m/s]."""
    result, gravity = loads.result, loads.result.scene.gravity
    last = len(result) - 1 if landed is None else landed - 1
    fell = (loads.centre[last] - loads.centre[last - 1]) * result.fps
    velocity = fell + 0.5 * gravity / result.fps
    squared = float(velocity @ velocity)
    if landed is not None:
        squared += 2.0 * float(gravity @ (loads.centre[landed] - loads.centre[last]))
    return float(np.sqrt(max(squared, 0.0)))
