"""Dents of soft things in the browser.

A server sends the vertices of a frame that differs from the one before. A page has the dents of all
frames in few numbers (`halfphysics.results.low_rank`), from which its script computes a frame's
(player/dents.js).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.low_rank import low_rank
from halfphysics.viewer.packing import packed

if TYPE_CHECKING:
    from halfphysics.render.rasterizer import Surface
    from halfphysics.results.dents import Dent
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Largest error of a vertex on a page [m], and most rows of numbers for one thing.
TOLERANCE, MOST_ROWS = 5e-4, 48
#: Most numbers of a page for one thing, two bytes each; with more its dents have larger errors.
MOST_NUMBERS = 400_000
#: Ways are in multiples of this: less than 8 for each metre of depth.
WAY_GRAIN = 2.0**-12


@dataclass(frozen=True, eq=False)
class SoftNode:
    """A soft item of a stage.

    Attributes:
        name: As in `Drawing`, such as "static/sofa".
        surface: Its mesh.
        dent: How that gives.
        handle: viser's handle of the mesh.
    """

    name: str
    surface: Surface
    dent: Dent
    handle: Any


def own_vertices(surface: Surface, handle: Any) -> Ints:
    """The vertex of a surface that each of viser's is: it has copies along sharp edges."""
    from scipy.spatial import cKDTree

    found = cKDTree(surface.vertices).query(np.asarray(handle.vertices, dtype=np.float64))[1]
    return np.asarray(found, dtype=np.int64)


class DentNodes:
    """The soft items of a stage, whose vertices are sent when they move.

    Args:
        nodes: The soft items.
    """

    def __init__(self, nodes: Sequence[SoftNode]) -> None:
        self._nodes = nodes
        self._own = [own_vertices(node.surface, node.handle) for node in nodes]
        self._shown = [-1] * len(nodes)

    def show(self, frame: int) -> None:
        """Show the dents of a frame."""
        for k, node in enumerate(self._nodes):
            depth, before = node.dent.depth, self._shown[k]
            at = min(frame, len(depth) - 1)
            flat = not depth[at].any() if before < 0 else np.array_equal(depth[at], depth[before])
            self._shown[k] = at
            if not flat:
                node.handle.vertices = node.dent.at(at)[self._own[k]].astype(np.float32)


def dent_document(stage: Stage, step: int) -> list[dict[str, Any]]:
    """The dents of a stage for a page that shows every `step`-th frame, by soft item.

    Each has `node`; `count`, the number of vertices of its mesh; `at`, those that move, as
    differences; `way`, where these go for each metre of depth, in multiples of `WAY_GRAIN`; and of
    `rows` rows of numbers, whole numbers of 16 bits that `unit` and 1/32767 scale, `depth`
    (rows, vertices) and `weight` (frames, rows): their product is the depth of every vertex.
    """
    found = []
    for node in stage.soft_items():
        dent = node.dent
        depth = dent.depth[::step].astype(np.float64)
        layer, own = dent.layer, own_vertices(node.surface, node.handle)
        place = np.full(len(layer.surface), -1)
        place[dent.vertices] = np.arange(len(dent.vertices))
        at = np.flatnonzero(place[own] >= 0)
        way = np.round(layer.way[own[at]] / WAY_GRAIN)
        most = min(MOST_ROWS, max(MOST_NUMBERS // (len(at) + len(depth)), 1))
        weights, rows, _ = low_rank(depth, TOLERANCE, most)
        unit = float(np.abs(rows).max(initial=1e-6)) / 32767.0
        found.append(
            {
                "node": stage.path(node.name),
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
