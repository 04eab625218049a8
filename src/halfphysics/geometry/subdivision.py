"""Triangles cut smaller where detail is needed, without cracks.

An edge is cut or not, for both of its faces alike, so neighbours always meet. A face with one, two
or three cut edges becomes two, three or four faces. Only edges nearly as long as the longest of
each of their faces are cut (Rivara 1997), so that no slivers are made.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: An edge is long that is at least this share of the longest edge of its face.
_LONG = 0.71
#: Rounds of halving: a face of 20 m comes down to 2 cm in 20, slivers take a few more.
_ROUNDS = 64


def subdivided(
    values: Array,
    faces: NDArray[np.integer],
    length: float,
    most: int,
    near: Callable[[Array, Array], NDArray[np.bool_]] | None = None,
) -> tuple[Array, Ints]:
    """A mesh with edges of at most `length`.

    Args:
        values: Columns of the vertices (V, k): the first three are positions [m]; all are linear
            in the faces, and new vertices get the mean of the edge's ends.
        faces: (F, 3).
        length: The longest edge [m].
        most: Stop before there are more vertices than this; edges are then longer.
        near: Given centres (n, 3) and radii (n,) of balls around faces: which faces to cut. None:
            all of them.

    Returns:
        Values (W, k), those given first, and faces (G, 3).
    """
    values = np.asarray(values, dtype=np.float64)
    triangles: Ints = np.asarray(faces, dtype=np.int64)
    for _ in range(_ROUNDS):
        cut = _edges_to_cut(values[:, :3], triangles, length, near)
        if not len(cut) or len(values) + len(cut) > most:
            break
        values, triangles = _cut(values, triangles, cut)
    return values, triangles


def _edges_to_cut(
    points: Array,
    faces: Ints,
    length: float,
    near: Callable[[Array, Array], NDArray[np.bool_]] | None,
) -> Ints:
    """The edges (n, 2) to halve, lower vertex first, each once."""
    corners = points[faces]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)  # k to k + 1
    longest = sides.max(axis=1)
    wanted = longest > length
    if near is not None and wanted.any():
        centre = corners[wanted].mean(axis=1)
        radius = np.linalg.norm(corners[wanted] - centre[:, None], axis=2).max(axis=1)
        wanted[wanted] = near(centre, radius)
    if not wanted.any():
        return np.zeros((0, 2), dtype=np.int64)
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    edges, which = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    which = which.reshape(-1, 3)
    long = sides >= _LONG * longest[:, None]
    # Halving a short edge of a face makes a sliver: its long edges are halved first.
    blocked = np.bincount(which[~long], minlength=len(edges)) > 0
    while True:
        asked = np.bincount(which[wanted[:, None] & long], minlength=len(edges)) > 0
        more = wanted | ((asked[which] & ~long).any(axis=1))
        if (more == wanted).all():
            return edges[asked & ~blocked]
        wanted = more


def _cut(values: Array, faces: Ints, cut: Ints) -> tuple[Array, Ints]:
    """Halve the edges `cut` (n, 2) of a mesh."""
    count = len(values)
    values = np.concatenate([values, 0.5 * (values[cut[:, 0]] + values[cut[:, 1]])])
    key = cut[:, 0] * count + cut[:, 1]
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    asked = ends[..., 0] * count + ends[..., 1]
    place = np.minimum(np.searchsorted(key, asked), len(key) - 1)
    middle = np.where(key[place] == asked, count + place, -1)  # (F, 3), -1: the edge stays
    number = (middle >= 0).sum(axis=1)
    parts = [faces[number == 0]]
    for some in (1, 2, 3):
        # Turn the corners: the one cut edge first; of two, the uncut edge last.
        mine = np.flatnonzero(number == some)
        state = middle[mine] >= 0
        first = np.argmax(state, axis=1) if some == 1 else (np.argmin(state, axis=1) + 1) % 3
        order = (first[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[mine], order, axis=1).T
        ab, bc, ca = np.take_along_axis(middle[mine], order, axis=1).T
        if some == 1:
            new = [(a, ab, c), (ab, b, c)]
        elif some == 2:
            new = _three(values[:, :3], (a, b, c), (ab, bc))
        else:
            new = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        parts += [np.stack(one, axis=1) for one in new]
    return values, np.concatenate(parts)


def _three(
    points: Array, corners: tuple[Ints, Ints, Ints], middles: tuple[Ints, Ints]
) -> list[tuple[Ints, Ints, Ints]]:
    """Three faces of each face a, b, c whose edges ab and bc are cut: by the shorter diagonal."""
    a, b, c = corners
    ab, bc = middles
    first = np.linalg.norm(points[ab] - points[c], axis=1)
    second = np.linalg.norm(points[bc] - points[a], axis=1)
    swap = second < first
    return [
        (ab, b, bc),
        (a, ab, np.where(swap, bc, c)),
        (np.where(swap, a, ab), bc, c),
    ]
