"""Triangles in a tree of boxes, for queries of many points: plain numpy, without the core.

For the judge of the skin (`skin_judge`): which boxes meet which triangles, distances of points,
and winding numbers of a surface.
"""

from __future__ import annotations

import numpy as np

from support import short_rows as rows

#: Items that go down the tree together: bounds the memory.
CHUNK = 8192
#: Levels of the tree that tell whether a point is near.
ROUGH = 9
#: Rays have this direction: oblique, so that they meet no edge of typical models.
RAY = np.array([0.2367, -0.1713, 0.9563])


class Boxes:
    """A balanced tree over boxes `low`, `high` (F, d), in the order of Morton's curve."""

    def __init__(self, low, high):
        depth = int(np.ceil(np.log2(max(1, len(low)))))
        fill = (1 << depth) - len(low)
        wide = ((0, fill), (0, 0))
        self.order = np.append(np.argsort(_along_curve(low + high)), len(low) + np.arange(fill))
        # Padding boxes meet no item.
        low = np.pad(low, wide, constant_values=np.inf)
        high = np.pad(high, wide, constant_values=-np.inf)
        self.levels = [(low[self.order], high[self.order])]
        for _ in range(depth):
            below, above = self.levels[0]
            ends = np.minimum(below[::2], below[1::2]), np.maximum(above[::2], above[1::2])
            self.levels.insert(0, ends)

    def pairs(self, items, meets, levels=None):
        """(item, box) of all pairs that meet.

        items: how many there are; meets(i, low, high): whether items `i` (k,) meet boxes (k, d).
        levels: depth limit: (item, box of that level).
        """
        down = self.levels[:levels]
        found = [np.zeros((2, 0), dtype=np.int64)]
        for first in range(0, items, CHUNK):
            item = np.arange(first, min(first + CHUNK, items))
            node = np.zeros(len(item), dtype=np.int64)
            for k, (low, high) in enumerate(down):
                if k:
                    item = np.repeat(item, 2)
                    node = (2 * node[:, None] + [0, 1]).ravel()
                keep = meets(item, low[node], high[node])
                item, node = item[keep], node[keep]
            found.append(np.stack([item, node if levels else self.order[node]]))
        return np.concatenate(found, axis=1)

    def overlapping(self, low, high):
        """Pairs (item, box) that meet, of items with boxes `low`, `high` (n, d)."""

        def meets(i, below, above):
            out = np.ones(len(i), dtype=bool)
            for k in range(low.shape[1]):  # numpy is slow along short rows
                out &= (low[i, k] <= above[:, k]) & (high[i, k] >= below[:, k])
            return out

        return self.pairs(len(low), meets)


def _along_curve(points):
    """Places (F,) of points (F, d) on Morton's curve: the bits of their coordinates take turns."""
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    bits = 60 // points.shape[1]
    extent = np.maximum(np.ptp(points, axis=0).max(), np.finfo(float).tiny)
    cells = ((points - points.min(axis=0)) * ((1 << bits) - 1) / extent).astype(np.int64)
    place = np.zeros(len(points), dtype=np.int64)
    for bit in range(bits - 1, -1, -1):
        for along in cells.T:
            place = (place << 1) | ((along >> bit) & 1)
    return place


def triangle_boxes(triangles):
    """Corners of boxes (F, 3) around triangles (F, 3, 3)."""
    return rows.smallest(triangles, 1), rows.largest(triangles, 1)


class Soup:
    """Triangles (F, 3, 3) [m], counter-clockwise seen from outside."""

    def __init__(self, triangles):
        self.triangles = np.asarray(triangles, dtype=float)
        low, high = triangle_boxes(self.triangles)
        self.low, self.high = low.min(axis=0), high.max(axis=0)
        self._boxes = Boxes(low, high)
        # The same, seen along the ray.
        u = np.cross(RAY, [1.0, 0.0, 0.0])
        u /= np.linalg.norm(u)
        n = RAY / np.linalg.norm(RAY)
        self._turn = np.stack([u, np.cross(n, u), n], axis=1)
        self._seen = self.triangles @ self._turn
        self._shadows = None

    def near(self, low, high):
        """Pairs (item, triangle) whose boxes meet; items have boxes `low`, `high` (n, 3)."""
        return self._boxes.overlapping(low, high)

    def smallest(self, points, most=np.inf):
        """Smallest distance of any of the points (n, 3), and its index; (inf, -1) beyond `most`."""
        square = most * most
        item, _ = self._boxes.pairs(
            len(points), lambda i, low, high: _beside(points[i], low, high) <= square, ROUGH
        )
        near = np.unique(item)
        if not len(near):
            return np.inf, -1
        # An upper bound: the best leaf on a walk straight down the tree.
        p = points[near]
        d = self._within(p, np.full(len(p), min(self._bound(p).min(), most)))
        i = int(d.argmin())
        return (float(d[i]), int(near[i])) if np.isfinite(d[i]) else (np.inf, -1)

    def distances(self, points):
        """Distances (n,) of points (n, 3)."""
        return self._within(points, self._bound(points))

    def _bound(self, points):
        """Distances (n,) of points to a nearby triangle."""
        node = np.zeros(len(points), dtype=np.int64)
        for low, high in self._boxes.levels[1:]:
            two = 2 * node[:, None] + [0, 1]
            away = _beside(points[:, None], low[two], high[two])
            node = two[np.arange(len(two)), away.argmin(axis=1)]
        # Rounding: triangles at exactly this distance are included.
        return (1.0 + 1e-9) * to_triangles(points, self.triangles[self._boxes.order[node]]) + 1e-12

    def _within(self, points, reach):
        """Distances (n,) of points, inf where beyond `reach` (n,)."""
        out, square = np.full(len(points), np.inf), reach * reach

        def meets(i, low, high):
            return _beside(points[i], low, high) <= square[i]

        item, which = self._boxes.pairs(len(points), meets)
        np.minimum.at(out, item, to_triangles(points[item], self.triangles[which]))
        return np.where(out <= reach, out, np.inf)

    def winding(self, points):
        """Winding number of the surface around points (n, 3): exact where it is closed."""
        if self._shadows is None:
            low, high = triangle_boxes(self._seen)
            low[:, 2] = high[:, 2]
            self._shadows = Boxes(low, high)
        p = points @ self._turn

        def meets(i, low, high):
            x, y, z = p[i].T
            under = (x >= low[:, 0]) & (x <= high[:, 0]) & (z <= high[:, 2])
            return under & (y >= low[:, 1]) & (y <= high[:, 1])

        item, which = self._shadows.pairs(len(p), meets)
        a, b, c = np.moveaxis(self._seen[which] - p[item, None], 1, 0)

        def turn(x, y):
            return x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]

        areas = np.stack([turn(b, c), turn(c, a), turn(a, b)], axis=1)
        sign = np.sign(areas.sum(axis=1))
        covered = rows.smallest(areas * sign[:, None]) > 0.0
        above = (areas * np.stack([a[:, 2], b[:, 2], c[:, 2]], axis=1)).sum(axis=1) * sign > 0.0
        return np.bincount(item, weights=sign * (covered & above), minlength=len(p))


def _beside(points, low, high):
    """Squared distances of points to boxes, pair by pair; inf for empty boxes."""
    away = np.maximum(np.maximum(low - points, points - high), 0.0)
    away *= away
    return away[..., 0] + away[..., 1] + away[..., 2]


def to_triangles(points, triangles):
    """Distances (k,) of points (k, 3) from triangles (k, 3, 3), pair by pair."""
    best = np.full(len(points), np.inf)
    normal = rows.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.einsum("ki,ki->k", normal, normal)
    within = size > 0.0
    for j in range(3):
        a, edge = triangles[:, j], triangles[:, (j + 1) % 3] - triangles[:, j]
        to = points - a
        length = np.einsum("ki,ki->k", edge, edge)
        t = np.einsum("ki,ki->k", to, edge) / np.where(length > 0.0, length, 1.0)
        gap = to - np.clip(t, 0.0, 1.0)[:, None] * edge
        best = np.minimum(best, np.einsum("ki,ki->k", gap, gap))
        within &= np.einsum("ki,ki->k", rows.cross(edge, to), normal) >= 0.0
    height = np.einsum("ki,ki->k", points - triangles[:, 0], normal)
    plane = height * height / np.where(size > 0.0, size, 1.0)
    return np.sqrt(np.where(within, np.minimum(best, plane), best))
