"""Dents of soft things in the browser.

A server sends the vertices of a frame that differs from the one before. A page has the dents of all
frames in few numbers (`halfphysics.results.low_rank`), from which its script computes a frame's
(player/dents.js).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.low_rank import low_rank
from halfphysics.viewer.packing import packed

if TYPE_CHECKING:
    from halfphysics.render.result_meshes import Item
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Largest error of a vertex on a page [m], and most rows of numbers for one thing.
TOLERANCE, MOST_ROWS = 5e-4, 48
#: Most numbers of a page for one thing, two bytes each; with more its dents have larger errors.
MOST_NUMBERS = 400_000
#: Ways are in multiples of this: less than 8 for each metre of depth.
WAY_GRAIN = 2.0**-12


def own_vertices(item: Item, handle: Any) -> Ints:
    """The vertex of an item's mesh that each of viser's is: it has copies along sharp edges."""
    from scipy.spatial import cKDTree

    found = cKDTree(item.surface.vertices).query(np.asarray(handle.vertices, dtype=np.float64))[1]
    return np.asarray(found, dtype=np.int64)


class DentNodes:
    """The soft items of a stage, whose vertices are sent when they move.

    Args:
        items: Name -> item, each with a dent.
        handles: Name -> viser's handle of its mesh.
    """

    def __init__(self, items: dict[str, Item], handles: dict[str, Any]) -> None:
        self._items = items
        self._handles = handles
        self._own = {name: own_vertices(item, handles[name]) for name, item in items.items()}
        self._shown = dict.fromkeys(items, -1)

    def show(self, frame: int) -> None:
        """Show the dents of a frame."""
        for name, item in self._items.items():
            assert item.dent is not None
            depth, before = item.dent.depth, self._shown[name]
            at = min(frame, len(depth) - 1)
            flat = not depth[at].any() if before < 0 else np.array_equal(depth[at], depth[before])
            self._shown[name] = at
            if not flat:
                moved = item.dent.at(at)[self._own[name]]
                self._handles[name].vertices = moved.astype(np.float32)


def dent_document(stage: Stage, step: int) -> list[dict[str, Any]]:
    """The dents of a stage for a page that shows every `step`-th frame, by soft item.

    Each has `node`; `count`, the number of vertices of its mesh; `at`, those that move, as
    differences; `way`, where these go for each metre of depth, in multiples of `WAY_GRAIN`; and of
    `rows` rows of numbers, whole numbers of 16 bits that `unit` and 1/32767 scale, `depth`
    (rows, vertices) and `weight` (frames, rows): their product is the depth of every vertex.
    """
    found = []
    for name, item, handle in stage.soft_items():
        dent = item.dent
        assert dent is not None
        depth = dent.depth[::step].astype(np.float64)
        layer, own = dent.layer, own_vertices(item, handle)
        place = np.full(len(layer.surface), -1)
        place[dent.vertices] = np.arange(len(dent.vertices))
        at = np.flatnonzero(place[own] >= 0)
        way = np.round(layer.way[own[at]] / WAY_GRAIN)
        most = min(MOST_ROWS, max(MOST_NUMBERS // (len(at) + len(depth)), 1))
        weights, rows, _ = low_rank(depth, TOLERANCE, most)
        unit = float(np.abs(rows).max(initial=1e-6)) / 32767.0
        found.append(
            {
                "node": stage.path(name),
                "count": len(own),
                "at": packed(np.diff(at, prepend=0), "<i4"),
                "way": packed(np.clip(way, -32767, 32767), "<i2"),
                "rows": len(rows),
                "unit": unit,
                "depth": packed(np.round(rows[:, place[own[at]]] / unit), "<i2"),
                "weight": packed(np.round(32767.0 * weights), "<i2"),
            }
        )
    return found
