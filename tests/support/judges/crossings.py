"""Could a convex piece get from one pose to the next without meeting a static?

A single sheet, a pole or a rod has no inside that a jump could end in, so poses alone do not tell.
`possible` requires a witness, a continuous motion of the piece:

- the sum of the distances at both ends exceeds the longest way of a vertex; or
- the hull of both sets of vertices is disjoint from the static, or, the step split into pieces,
  their hulls are: the vertices move straight; or
- the motion of the body (root straight, rotations by the shortest arc) is clear, by conservative
  advancement; or
- two or four such motions are, over poses stepped back a little (`DETOURS`): a split step may bend
  around an edge.

Only the last three can miss a way that exists, and only near obstacles.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import coal
import numpy as np

from support.judges.coal_shapes import coal_hull

#: A step without witness is halved at most this often.
STRAIGHT_DEPTH, ARC_DEPTH, BENT_DEPTH = 4, 12, 1
#: How far a piece may step back from an obstacle on its way from one pose to the next [m]: too
#: little to get around any obstacle of the throws.
DETOURS = (0.005, 0.02)
HERE, TOUCHING = coal.Transform3s(), coal.CollisionRequest()


class Way:
    """The motion of piece i from pose k to the next, without other influence."""

    def __init__(self, at, i, k):
        self._at, self._i, self._k = at, i, k
        self.ends = at.points(i, k), at.points(i, k + 1)

    @property
    def length(self):
        """An upper bound of the way of a corner [m]."""
        return self._at.length(self._i, self._k)

    def points(self, share):
        """Corners (n, 3) at a share of the way."""
        return self._at.between(self._i, self._k, share)


@dataclass
class _Stop:
    """A point of a way, at a share of it and moved by an offset (3,): distance and direction."""

    share: float
    offset: np.ndarray
    gap: float
    away: np.ndarray


def possible(way, s, before, after, patient=True):
    """Whether a `Way` past the static `s` has a witness.

    before, after: Distance and direction at its ends, as `JudgedStatic.distance` has them.
    patient: Tries detours too.
    """
    if before[0] <= 0.0 or after[0] <= 0.0:
        return True  # inside at a committed pose: counted there
    w0, w1 = way.ends
    if before[0] + after[0] > np.sqrt(np.max(np.sum((w1 - w0) ** 2, axis=1))):
        return True
    a, b = _Stop(0.0, np.zeros(3), *before), _Stop(1.0, np.zeros(3), *after)
    return (
        _straight(w0, w1, s, STRAIGHT_DEPTH)
        or _arc(way, s, a, b, ARC_DEPTH)
        or (patient and _bent(way, s, a, b, BENT_DEPTH))
    )


def _straight(w0, w1, s, depth):
    hull, result = coal_hull(np.concatenate([w0, w1])), coal.CollisionResult()
    if not coal.collide(hull, HERE, s.shape, s.place, TOUCHING, result):
        return True
    if depth == 0:
        return False
    middle = 0.5 * (w0 + w1)
    return _straight(w0, middle, s, depth - 1) and _straight(middle, w1, s, depth - 1)


def _stop(way, s, share, offset):
    points = way.points(share) + offset
    gap, away = s.distance(points, (coal_hull(points), HERE))
    return _Stop(share, offset, gap, away)


def _bent(way, s, a, b, depth):
    """The body's motion in two halves, and in four, over poses stepped back from the middle."""
    ends = [stop.away / max(np.linalg.norm(stop.away), 1e-12) for stop in (a, b)]
    out = [*ends, ends[0] + ends[1]]
    for share, n, detour in product((0.5, 0.0, 1.0), out, DETOURS):
        offset = a.offset + share * (b.offset - a.offset) + detour * n
        there = _stop(way, s, a.share + share * (b.share - a.share), offset)
        if there.gap <= 0.0:
            continue
        if all(
            _arc(way, s, c, d, ARC_DEPTH) or (depth > 0 and _bent(way, s, c, d, depth - 1))
            for c, d in ((a, there), (there, b))
        ):
            return True
    return False


def _arc(way, s, a, b, depth):
    length = (b.share - a.share) * way.length + np.linalg.norm(b.offset - a.offset)
    if a.gap + b.gap > length:
        return True
    if depth == 0:
        return False
    middle = _stop(way, s, 0.5 * (a.share + b.share), 0.5 * (a.offset + b.offset))
    if middle.gap <= 0.0:
        return False
    return _arc(way, s, a, middle, depth - 1) and _arc(way, s, middle, b, depth - 1)
