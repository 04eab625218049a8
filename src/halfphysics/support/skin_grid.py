"""A sparse choice of the skin's vertices: about one in every square of 2.5 cm of its surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

#: Side of the squares [m]: a sole has some 40 of them.
PITCH = 0.025
#: How much further than at rest a part's skin may be from its middle when posed [m].
BULGE = 0.04

_known: WeakKeyDictionary[Body, SkinGrid] = WeakKeyDictionary()


@dataclass(frozen=True, kw_only=True, eq=False)
class SkinGrid:
    """Vertices of the skin, grouped by part: the one with the largest weight.

    Attributes:
        vertex: Indices into the skin (n,), part by part.
        part: Part of each (n,), ascending.
        normal: The skin's unit normal at each at rest (n, 3), rest frame.
        first: Where the vertices of each part start, and their number (56,).
        middle: Middle of each part's skin at rest, from its joint (55, 3) [m], rest frame.
        radius: Of a ball about it that holds the part's skin at any pose (55,) [m].
    """

    vertex: Ints
    part: Ints
    normal: Array
    first: Ints
    middle: Array
    radius: Array


def skin_grid(body: Body) -> SkinGrid:
    """The sparse vertices of a body; made once per body.

    In each square those of one part that face the same way of six (up, down, left, ...), of which
    the outermost is chosen: a sole's vertices are those that touch first.
    """
    if body not in _known:
        _known[body] = _made(body)
    return _known[body]


def _made(body: Body) -> SkinGrid:
    rest = body.rest_vertices
    part = body.weights.argmax(axis=1)
    normal = _normals(rest, body.faces)
    axis = np.abs(normal).argmax(axis=1)
    rows = np.arange(len(rest))
    sign = np.sign(normal[rows, axis])
    cell = np.floor(rest / PITCH).astype(np.int64)
    cell[rows, axis] = 0  # one layer along the way that the skin faces
    height = sign * rest[rows, axis]
    used = np.zeros(len(rest), dtype=bool)
    used[np.unique(body.faces)] = True
    keys = np.column_stack([part, axis, sign.astype(np.int64), cell])
    order = np.lexsort((rows, -height, *keys.T[::-1]))
    order = order[used[order]]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (keys[order[1:]] != keys[order[:-1]]).any(axis=1)
    chosen = order[new]
    chosen = chosen[np.lexsort((chosen, part[chosen]))]
    middle, radius = np.zeros((N_JOINTS, 3)), np.zeros(N_JOINTS)
    for k in np.unique(part):
        own = rest[part == k] - body.rest_joints[k]
        middle[k] = 0.5 * (own.min(axis=0) + own.max(axis=0))
        radius[k] = np.linalg.norm(own - middle[k], axis=1).max() + BULGE
    return SkinGrid(
        vertex=chosen.astype(np.int32),
        part=part[chosen].astype(np.int32),
        normal=normal[chosen] / np.linalg.norm(normal[chosen], axis=1, keepdims=True),
        first=np.searchsorted(part[chosen], np.arange(N_JOINTS + 1)).astype(np.int32),
        middle=middle,
        radius=radius,
    )


def _normals(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Normals of the vertices (V, 3), weighted by area; not of unit length."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    across = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for corner in faces.T:
        np.add.at(total, corner, across)
    return total
