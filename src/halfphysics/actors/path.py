"""A way over the floor: a line of points, by the distance along it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple


class Point(NamedTuple):
    """A place on the floor [m]."""

    x: float
    y: float


class Path:
    """A polyline.

    Args:
        points: At least one; points that coincide count once.
        foreseen: Distance along it up to which the way was looked for [m]: what comes after that
            is only a direction. None: all of it.
    """

    def __init__(self, points: Sequence[Point], foreseen: float | None = None) -> None:
        self.points = [points[0]]
        self._at = [0.0]
        for point in points[1:]:
            way = math.dist(point, self.points[-1])
            if way > 1e-9:
                self.points.append(point)
                self._at.append(self._at[-1] + way)
        self.foreseen = self.length if foreseen is None else foreseen

    @property
    def length(self) -> float:
        """Of the whole [m]."""
        return self._at[-1]

    @property
    def end(self) -> Point:
        """Its last point."""
        return self.points[-1]

    def _segment(self, distance: float) -> int:
        return min(max(bisect_right(self._at, distance) - 1, 0), len(self.points) - 2)

    def at(self, distance: float) -> Point:
        """The point at a distance along the path [m], its end beyond."""
        if len(self.points) == 1:
            return self.points[0]
        i = self._segment(distance)
        a, b, way = self.points[i], self.points[i + 1], self._at[i + 1] - self._at[i]
        share = min(max((distance - self._at[i]) / way, 0.0), 1.0)
        return Point(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))

    def heading(self, distance: float) -> float | None:
        """Direction of the path there, about z [rad]; None: the path has no length."""
        if len(self.points) == 1:
            return None
        i = self._segment(distance)
        a, b = self.points[i], self.points[i + 1]
        return math.atan2(b.y - a.y, b.x - a.x)

    def nearest(self, x: float, y: float) -> float:
        """Distance along the path of its point nearest to (x, y) [m]."""
        best, found = math.inf, 0.0
        for i, (a, b) in enumerate(zip(self.points, self.points[1:], strict=False)):
            dx, dy, way = b.x - a.x, b.y - a.y, self._at[i + 1] - self._at[i]
            t = min(max(((x - a.x) * dx + (y - a.y) * dy) / (way * way), 0.0), 1.0)
            off = math.hypot(a.x + t * dx - x, a.y + t * dy - y)
            if off < best - 1e-12:
                best, found = off, self._at[i] + t * way
        return found

    def rounded(self, reach: float = 0.22) -> Path:
        """The path with its corners cut, each over at most `reach` before and behind it [m]."""
        if len(self.points) < 3:
            return self
        out = [self.points[0]]
        for before, corner, after in zip(
            self.points, self.points[1:], self.points[2:], strict=False
        ):
            a, b = _toward(corner, before, reach), _toward(corner, after, reach)
            for t in (0.0, 0.25, 0.5, 0.75, 1.0):
                p, q, r = (1.0 - t) ** 2, 2.0 * t * (1.0 - t), t * t
                out.append(
                    Point(p * a.x + q * corner.x + r * b.x, p * a.y + q * corner.y + r * b.y)
                )
        return Path([*out, self.points[-1]])


def _toward(start: Point, end: Point, reach: float) -> Point:
    way = math.dist(start, end)
    share = min(0.45, reach / way)
    return Point(start.x + share * (end.x - start.x), start.y + share * (end.y - start.y))
