"""When recorded parts of a person hold a recorded thing, from distances and relative speeds.

Parts are hands, feet that push, or the seat (parts.py). A thing moves where its recorded poses do.
A part belongs to it in frames in which its skin is near the thing's surface and slow against it,
with hysteresis: sensors err by centimetres. A hold lasts while the thing moves or rests with the
parts still at it; who is there most of the time it moves holds it. Nothing here knows of contact or
weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from halfphysics.adaptation.hands import Hand
from halfphysics.adaptation.parts import Part
from halfphysics.adaptation.thing import Thing

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A thing moves faster than this [m/s] or turns faster [rad/s], over `_OVER` [s].
_MOVES, _TURNS, _OVER = 0.06, 0.3, 0.15
#: A shorter rest [s] with the hands still there does not end a hold.
_RESTS = 2.0
#: Moves of less than this [m] are a touch, not a hold.
_LEAST = 0.03
#: A hand comes to a thing nearer than the first, and leaves it beyond the second [m].
_NEAR, _LEAVES = 0.06, 0.09
#: A hand at a thing that rests has let go when it is farther than it was as the thing moved by this
#: [m], or moves against it faster than this [m/s].
_AWAY, _OFF = 0.02, 0.08
#: It is slow against the thing below this [m/s].
_SLOW = 0.35
#: Share of the time that a thing moves in which a hand that holds it is there.
_THERE = 0.6
#: Part of a hand's inner side that is nearest: its distance is the hand's.
_NEAREST = 0.1


@dataclass(frozen=True, eq=False)
class RecordedHold:
    """A thing held by parts of one person.

    Attributes:
        thing: What is held.
        parts: What holds it.
        first: Frame in which it begins to move.
        last: Last frame in which it is held.
        arrives: Per part, the first frame in which it is at the thing.
        kept: The recording ends with the thing in the hands.
        rests: Last frame in which the thing moves.
    """

    thing: Thing
    parts: tuple[Part, ...]
    first: int
    last: int
    arrives: tuple[int, ...]
    kept: bool
    rests: int

    @property
    def hands(self) -> tuple[Hand, ...]:
        """Those of its parts that are hands."""
        return tuple(part for part in self.parts if isinstance(part, Hand))

    @property
    def middle(self) -> int:
        """A frame in which hands have settled."""
        return (self.first + self.last) // 2


def recorded_holds(
    motion: Motion, body: Body, parts: Sequence[Part], thing: Thing
) -> list[RecordedHold]:
    """All holds of a thing by parts of a person, in the order of time.

    Args:
        motion: The recorded motion, T frames.
        body: The person's body.
        parts: Of that body, of one kind: hands, feet or the seat.
        thing: With poses for each of the T frames.
    """
    if not parts:
        return []
    seen = [_Seen.of(motion, body, part, thing) for part in parts]
    at = [each.at for each in seen]
    found = []
    for first, last in _moving(thing, motion.fps, np.any(at, axis=0)):
        moves = slice(first, last + 1)
        there = [k for k, mask in enumerate(at) if mask[moves].mean() > _THERE]
        if not there:
            continue
        ends = [seen[k].leaves(first, last, motion.fps) for k in there]
        end = min(ends)
        arrives = []
        for k in there:
            frame = first
            while frame > 0 and at[k][frame - 1]:
                frame -= 1
            arrives.append(frame)
        found.append(
            RecordedHold(
                thing=thing,
                parts=tuple(parts[k] for k in there),
                first=first,
                last=end,
                arrives=tuple(arrives),
                kept=end == len(motion) - 1,
                rests=min(last, end),
            )
        )
    return found


@dataclass(frozen=True, eq=False)
class _Seen:
    """One part against a thing, frame by frame.

    Attributes:
        gap: How far the nearest of its inner side is from the surface (T,) [m].
        speed: Mean speed of its inner side against the thing, over `_OVER` (T,) [m/s].
        at: It is at the thing (T,).
    """

    gap: Array
    speed: Array
    at: Mask

    @classmethod
    def of(cls, motion: Motion, body: Body, part: Part, thing: Thing) -> _Seen:
        points = thing.seen(body.vertices(motion, indices=part.inner))
        gaps = np.abs(thing.gaps(points))
        count = max(1, round(_NEAREST * gaps.shape[1]))
        nearest = np.argpartition(gaps, count - 1, axis=1)[:, :count]
        gap = np.take_along_axis(gaps, nearest, axis=1).mean(axis=1)
        speed = np.linalg.norm(_velocity(points, motion.fps), axis=2).mean(axis=1)
        at, inside = np.zeros(len(motion), dtype=bool), False
        for frame in range(len(motion)):
            near = bool(gap[frame] < (_LEAVES if inside else _NEAR))
            inside = near and bool(speed[frame] < _SLOW)
            at[frame] = inside
        return cls(gap, speed, at)

    def leaves(self, first: int, last: int, fps: float) -> int:
        """The last frame in which the hand holds what moved from `first` to `last`.

        It rests with the hand on it, until the hand moves off it or is farther away than before.
        """
        most = float(np.median(self.gap[first : last + 1])) + _AWAY
        end, moves_off = last, None
        # Its speed rises by up to half the window before it moves.
        late = _span(fps) // 2
        while end + 1 < len(self.at) and self.at[end + 1] and self.gap[end + 1] < most:
            if moves_off is None and self.speed[end + 1] > _OFF:
                moves_off = end + 1
            if moves_off is not None and end + 1 >= moves_off + late:
                break
            end += 1
            if end - last > _RESTS * fps:
                return last
        return end


def _span(fps: float) -> int:
    """Frames to each side over which speeds are taken."""
    return max(1, round(_OVER * fps))


def _velocity(points: Array, fps: float) -> Array:
    """Velocities (T, ...) [m/s] of points (T, ...): slopes of least squares, over what frames there
    are of the window about each. Differences of neighbours would be the sensor's noise."""
    span, frames = _span(fps), len(points)
    time = np.arange(-span, span + 1.0)

    def summed(values: Array, weights: Array) -> Array:
        result: Array = correlate1d(values, weights, axis=0, mode="constant")
        return result

    one = np.ones(frames)
    count, sum_t, sum_tt = (summed(one, time**k) for k in range(3))
    spread = np.maximum(sum_tt - sum_t**2 / count, 0.5)  # of two frames it is 0.5, of one 0
    middle = (sum_t / count).reshape(-1, *(1,) * (points.ndim - 1))
    away = points - points[:1]  # far from the origin sums would round
    slope = summed(away, time) - middle * summed(away, np.ones_like(time))
    result: Array = fps * slope / spread.reshape(middle.shape)
    return result


def _moving(thing: Thing, fps: float, near: Mask) -> list[tuple[int, int]]:
    """First and last frames in which the thing moves, short rests in the hands included."""
    span = _span(fps)
    frames = len(thing.position)
    before = np.maximum(np.arange(frames) - span, 0)
    after = np.minimum(np.arange(frames) + span, frames - 1)
    time = np.maximum(after - before, 1) / fps
    speed = np.linalg.norm(thing.centre[after] - thing.centre[before], axis=1) / time
    turned = np.einsum("tji,tjk->tik", thing.turn[before], thing.turn[after])
    cosine = 0.5 * (np.trace(turned, axis1=1, axis2=2) - 1.0)
    turns = np.arccos(np.clip(cosine, -1.0, 1.0)) / time
    moves = (speed > _MOVES) | (turns > _TURNS)
    out: list[tuple[int, int]] = []
    for frame in np.flatnonzero(moves):
        held = bool(out) and near[out[-1][1] : frame].mean() > _THERE
        if out and (frame == out[-1][1] + 1 or (held and frame - out[-1][1] < _RESTS * fps)):
            out[-1] = out[-1][0], int(frame)
        else:
            out.append((int(frame), int(frame)))
    # The window widens every move by up to half of it to both sides.
    trims = [min(span // 2, (b - a) // 2) for a, b in out]
    return [
        (a + trim, b - trim)
        for (a, b), trim in zip(out, trims, strict=True)
        if np.linalg.norm(thing.centre[a : b + 1] - thing.centre[a], axis=1).max() > _LEAST
        or turns[a : b + 1].max() > _TURNS
    ]
