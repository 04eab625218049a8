"""Loads on an object: which share of its weight people bear, and which share everything else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_NAMES

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.scene.items import Object

Array = NDArray[np.float64]
Frames = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: Forces that differ by less than this share are equal.
_ROUNDING = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Loads:
    """Forces of people, statics and other objects on one object.

    Attributes:
        result, item: The result and the object.
        rows: Rows of ``result.contacts`` in which people push the object (k,), ordered by frame.
        share: Size of the impulse of each of those rows, as a share of the object's weight over a
            frame (k,).
        people: Sum of `share` over all people (T,).
        elsewhere: Share of the weight that statics and other objects bear (T,): upward impulses.
        touched: Frames (T,) in which statics or other objects push the object.
        up: Unit vector against gravity (3,), zero without gravity.
        centre: Centre of mass (T, 3) [m].
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
        """The loads of an object of the result's scene."""
        contacts, index = result.contacts, result.names.index(item.name)
        gravity = np.asarray(result.scene.gravity)
        g = float(np.linalg.norm(gravity))
        up = -gravity / g if g else np.zeros(3)
        # Without gravity there is no weight: every contact bears all of it.
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
        """Share of the weight that a person bears (T,): upward, or without gravity of any kind."""
        contacts = self.result.contacts
        own = contacts.person[self.rows] == person
        rows, values = self.rows[own], self.share[own]
        if self.up.any():
            values = -(contacts.impulse[rows] @ self.up) * values / contacts.strength[rows]
        return summed(contacts.frame[rows], values, len(self.result))

    def holders(self, first: int, last: int, load: float) -> tuple[list[int], list[str]]:
        """People (indices) and parts (names) that exert at least a share `load` of all impulses;
        the strongest where none does."""
        contacts = self.result.contacts
        frame = contacts.frame[self.rows]
        within = (frame >= first) & (frame <= last)
        pairs, place = np.unique(
            np.stack([contacts.person, contacts.part])[:, self.rows[within]],
            axis=1,
            return_inverse=True,
        )
        total = summed(place.reshape(-1), contacts.strength[self.rows[within]], pairs.shape[1])
        carry = pairs[:, bears(total, total.sum(), total.max(), load)]
        return sorted(set(carry[0].tolist())), [JOINT_NAMES[p] for p in sorted(set(carry[1]))]


def bears(force: Array, total: Array | float, most: Array | float, load: float) -> Mask:
    """Which forces (k,) are at least a share `load` of their totals (k,), or the largest of them.

    Where many fingers share a thing, none may have that share: then the strongest, of size `most`
    (k,), carry it, those that rounding alone makes weaker included.
    """
    result: Mask = force >= np.minimum(load * total, (1.0 - _ROUNDING) * most)
    return result


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
    """Number of whole frames in a time [s]; a rounding error is not a frame."""
    return int(np.floor(seconds * fps + 1e-6))


def lasts(first: int, last: int, seconds: float, fps: float) -> bool:
    """Whether an event seen in frames `first` to `last`, inclusive, takes at least `seconds`.

    A short contact around the end of a frame is seen in two frames, which are long at a low frame
    rate although the contact is a kick. So an event of a positive duration takes three frames.
    """
    frames = last - first + 1
    return frames >= seconds * fps - 1e-6 and (frames > 2 or seconds == 0.0)
