"""A way from one place to another around what is in between.

Straight where nothing is in the way; else the shortest way over a grid (A*), which prefers to keep
some distance, pulled tight and its corners cut.
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from halfphysics.actors.floor_plan import FloorPlan
from halfphysics.actors.path import Path, Point

Array = NDArray[np.float64]

#: Distance of the middle of a walking person from what it passes [m]: preferred, and least.
ROOM, NARROW = 0.48, 0.31
# Side of a cell [m]; what the grid has beyond start and end [m], at first and at the second try.
_CELL = 0.1
_MARGINS = (2.5, 8.0)
# Near start and end a person may be nearer to things than `NARROW` [m]: it stands there.
_ENDS = 0.6
# What a metre costs at the least distance, and beyond it near the ends.
_TIGHT, _BEYOND = 4.0, 12.0
# How far ahead a way is looked for [m]: from there on it goes straight on.
_FORESEEN = 50.0
# A part of a way that is shorter leads nowhere [m].
_SOMEWHERE = 1.0
_SIDES = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)]


def route(plan: FloorPlan, start: Point, end: Point, moving: Array) -> Path | None:
    """A way around what is in between; None: there is none.

    Of an end that is far away only the first 50 m are looked for (`Path.foreseen`): to the point
    there, or where nothing leads to that, to the nearest one that can be reached.

    Args:
        plan: What stands there.
        start, end: Where from and where to.
        moving: More points in the way (n, 2) [m], as `FloorPlan.moving` has them.
    """
    way = math.dist(start, end)
    if way > _FORESEEN * (1.0 + 1e-9):
        share = _FORESEEN / way
        near = Point(start.x + share * (end.x - start.x), start.y + share * (end.y - start.y))
        first = _found(plan, start, near, moving, partly=True)
        if first is None or math.dist(start, first.end) < _SOMEWHERE:
            return None
        return Path([*first.points, end], foreseen=first.length)
    return _found(plan, start, end, moving)


def _found(
    plan: FloorPlan, start: Point, end: Point, moving: Array, partly: bool = False
) -> Path | None:
    """A way; where none leads to the end and `partly`, one to the nearest place that can be
    reached."""
    if _clear(plan, moving, start, end):
        return Path([start, end])
    for margin in _MARGINS:
        last = partly and margin == _MARGINS[-1]
        grid = _Grid(plan, moving, start, end, margin)
        cells = grid.search(partly=last)
        if cells:
            there = cells[-1] if grid.ends_short else end
            tight = _pulled([start, *cells[1:-1], there], plan, moving)
            return Path(tight).rounded()
    return None


def _clear(plan: FloorPlan, moving: Array, a: Point, b: Point, room: float = ROOM) -> bool:
    """Whether a straight way keeps its distance, but for its ends."""
    way = math.dist(a, b)
    share = np.linspace(0.0, 1.0, max(2, math.ceil(way / 0.08)))
    places = np.outer(1.0 - share, a) + np.outer(share, b)
    free = plan.clearance(places, moving)
    # At the ends no more is asked than what there is.
    near = np.minimum(share, 1.0 - share) * way < _ENDS
    least = np.where(near, np.minimum(room, min(free[0], free[-1]) - 1e-9), room)
    return bool((free >= least).all())


def _pulled(points: list[Point], plan: FloorPlan, moving: Array) -> list[Point]:
    """Without the points that a straight way can leave out."""
    out, i = [points[0]], 0
    while i < len(points) - 1:
        j = len(points) - 1
        while j > i + 1 and not _as_clear(points[i : j + 1], plan, moving):
            j = i + 1 + (j - i - 1) // 2 if j - i > 8 else j - 1
        out.append(points[j])
        i = j
    return out


def _as_clear(points: list[Point], plan: FloorPlan, moving: Array) -> bool:
    """Whether the straight way is as free as the way through points, or as one would like."""
    own = float(plan.clearance(np.array(points), moving).min())
    return _clear(plan, moving, points[0], points[-1], min(ROOM, max(own, 0.0)))


class _Grid:
    def __init__(
        self, plan: FloorPlan, moving: Array, start: Point, end: Point, margin: float
    ) -> None:
        low = np.minimum(start, end) - margin
        count = np.ceil((np.maximum(start, end) + margin - low) / _CELL).astype(int) + 1
        self._low, self._count = low, (int(count[0]), int(count[1]))
        i, j = np.indices(self._count)
        places = low + _CELL * np.stack([i, j], axis=-1).reshape(-1, 2)
        free = plan.clearance(places, moving)
        ends = np.minimum(
            np.linalg.norm(places - start, axis=1), np.linalg.norm(places - end, axis=1)
        )
        tight = np.clip((ROOM - free) / (ROOM - NARROW), 0.0, 1.0)
        cost = 1.0 + (_TIGHT - 1.0) * tight
        cost[free < NARROW] = np.where(ends[free < NARROW] < _ENDS, _BEYOND, np.inf)
        self._cost: list[list[float]] = cost.reshape(self._count).tolist()
        self._start, self._end = self._cell(start), self._cell(end)
        #: Whether the last search found only a place near the end.
        self.ends_short = False

    def _cell(self, at: Point) -> tuple[int, int]:
        i, j = np.rint((np.array(at) - self._low) / _CELL).astype(int)
        return int(i), int(j)

    def search(self, partly: bool = False) -> list[Point]:
        """Cells from start to end, none where there is no way; then, if `partly`, to the cell
        nearest to the end of those that can be reached."""
        start, end, cost = self._start, self._end, self._cost
        best = {start: 0.0}
        before: dict[tuple[int, int], tuple[int, int]] = {}
        open_ = [(math.dist(start, end), start)]
        done: set[tuple[int, int]] = set()
        while open_:
            _, at = heapq.heappop(open_)
            if at == end:
                return self._way(before, end)
            if at in done:
                continue
            done.add(at)
            for dx, dy in _SIDES:
                to = (at[0] + dx, at[1] + dy)
                if not (0 <= to[0] < self._count[0] and 0 <= to[1] < self._count[1]):
                    continue
                new = (
                    best[at] + (1.0 if not (dx and dy) else 1.4142135623730951) * cost[to[0]][to[1]]
                )
                if new < best.get(to, math.inf):
                    best[to], before[to] = new, at
                    heapq.heappush(open_, (new + math.dist(to, end), to))
        if not partly:
            return []
        self.ends_short = True
        return self._way(before, min(done, key=lambda cell: (math.dist(cell, end), cell)))

    def _way(
        self, before: dict[tuple[int, int], tuple[int, int]], end: tuple[int, int]
    ) -> list[Point]:
        cells = [end]
        while cells[-1] in before:
            cells.append(before[cells[-1]])
        x, y = self._low
        return [Point(float(x + _CELL * i), float(y + _CELL * j)) for i, j in reversed(cells)]
