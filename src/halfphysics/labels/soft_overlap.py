"""Where soft things and a skin overlap: what is inside the other one touches it.

A layer gives way, so skin sinks into it by centimetres and its vertices into the skin. Distances
from surfaces grow with the depth there; these rows have the distance 0 instead.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh_queries import MeshQuery, is_closed

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.labels.item_solids import ItemSolids

Array = NDArray[np.float64]
Whole = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Frame, vertex, distance [m], nearest vertex of the skin, (n,) each, and its point (n, 3).
Rows = tuple[Whole, Whole, Array, Whole, Array]


def close_inside(item: ItemSolids, centres: Array, close: Mask, asked: Mask, frames: Whole) -> Mask:
    """The spheres (t, g) that are `close` to an item, and those of `asked` that are in its solids.

    What is near no surface is inside or outside as a whole: its centre (t, g, 3) decides.
    """
    t, g = np.nonzero(asked & ~close)
    found = close.copy()
    inside = _in_item(item, centres[t, g], t, frames)
    found[t[inside], g[inside]] = True
    return found


def with_sunk(
    item: ItemSolids,
    posed: Array,
    wanted: Mask,
    frames: Whole,
    rows: tuple[Whole, Whole, Array],
) -> tuple[Whole, Whole, Array]:
    """Rows (n,) of frames, vertices and distances, and those inside an item, at a distance of 0.

    Args:
        item: What is soft.
        posed: Vertices (t, n, 3) in the world [m].
        wanted: Those that count (t, n).
        frames: The frames (t,) of the item's track.
        rows: What is near its surface.
    """
    t, v = np.nonzero(wanted)
    inside = _in_item(item, posed[t, v], t, frames)
    t, v = t[inside], v[inside]
    others = ~np.isin(rows[0] * wanted.shape[1] + rows[1], t * wanted.shape[1] + v)
    return (
        np.append(rows[0][others], t),
        np.append(rows[1][others], v),
        np.append(rows[2][others], np.zeros(len(t))),
    )


def with_swallowed(
    item: ItemSolids, points: Array, body: Body, skins: Array, frames: Whole, rows: Rows
) -> Rows:
    """Rows of an item's vertices near the skin, and those inside it, at a distance of 0.

    Args:
        item: What is soft.
        points: Its vertices (V, 3) in its frame [m].
        body: Whose skin it is; its parts that do not collide with the item swallow nothing.
        skins: The whole skin (t, W, 3) in the world [m].
        frames: The frames (t,) of the item's track.
        rows: What is near the skin; points of the skin in the item's frame.
    """
    position, turn = item.at(frames)
    closed = is_closed(np.asarray(body.faces), skins.shape[1])
    collides = item.parts[body.weights.argmax(axis=1)]
    found = [rows]
    for k, skin in enumerate(skins):
        at = 0 if item.still else k
        local = (skin - position[at]) @ turn[at]
        near = (points >= local.min(axis=0)) & (points <= local.max(axis=0))
        some = np.flatnonzero(near.all(axis=1))
        if not len(some):
            continue
        query = MeshQuery(local, body.faces, closed=closed)
        some = some[query.inside(points[some])]
        _, face, place = query.closest(points[some])
        corners = body.faces[face]
        mine = collides[corners].all(axis=1)
        some, corners, place = some[mine], corners[mine], place[mine]
        apart = np.linalg.norm(local[corners] - place[:, None], axis=2).argmin(axis=1)
        nearest = corners[np.arange(len(some)), apart]
        found.append((np.full(len(some), k), some, np.zeros(len(some)), nearest, place))
    frame, vertex, distance, nearest, place = (
        np.concatenate(columns) for columns in zip(*found, strict=True)
    )
    # Sorted by frame and vertex; of two rows of one vertex, the one with the smaller distance.
    order = np.lexsort((distance, vertex, frame))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(frame[order]) != 0) | (np.diff(vertex[order]) != 0)
    kept = order[first]
    return frame[kept], vertex[kept], distance[kept], nearest[kept], place[kept]


def _in_item(item: ItemSolids, points: Array, t: Whole, frames: Whole) -> Mask:
    """Whether points (n, 3) in the world in the frames number t (n,) are in an item's solids."""
    position, turn = item.at(frames)
    at = np.zeros_like(t) if item.still else t
    return item.inside(np.einsum("nj,njk->nk", points - position[at], turn[at]))
