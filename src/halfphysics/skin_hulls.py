"""The skin in convex pieces: vertex sets whose hulls cover it at every pose.

A face whose three vertices are in one set lies in the hull of that set wherever skinning takes
its vertices: hulls that are clear of something mean skin that is clear of it. Sets follow the
joints, so that a hull spans no two regions that move apart, and are cut further where their hulls
bulge over the skin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Sets the skin is cut into.
HULLS = 90


@dataclass(frozen=True, kw_only=True, eq=False)
class SkinHulls:
    """Vertex sets of a skin, each of whole faces; every face in one of them.

    Attributes:
        part: Joint that each hull belongs to, shape (H,): the one whose summed weight is largest
            on its faces.
        first: Where the vertices of each hull start in `vertex`, and their number, shape (H + 1,).
        vertex: Vertices of hull h, ascending: ``vertex[first[h]:first[h + 1]]``.
    """

    part: Ints
    first: Ints
    vertex: NDArray[np.int32]


def skin_hulls(faces: ArrayLike, weights: ArrayLike, rest_vertices: ArrayLike) -> SkinHulls:
    """Cut a skin into vertex sets of whole faces.

    Args:
        faces: Triangles, shape (F, 3).
        weights: Skinning weights, shape (V, 55).
        rest_vertices: Skin at rest [m], shape (V, 3).
    """
    triangles = np.asarray(faces, dtype=np.int64)
    vertices = np.asarray(rest_vertices, dtype=np.float64)
    joint = np.asarray(weights, dtype=np.float64)[triangles].sum(axis=1).argmax(axis=1)
    centres = vertices[triangles].mean(axis=1)
    pieces = [np.flatnonzero(joint == k) for k in range(55)]
    pieces = [piece for piece in pieces if len(piece)]
    while len(pieces) < HULLS:
        spans = [float(np.linalg.norm(np.ptp(centres[piece], axis=0))) for piece in pieces]
        widest = int(np.argmax(spans))
        piece = pieces[widest]
        if len(piece) < 2:
            break
        offsets = centres[piece] - centres[piece].mean(axis=0)
        along = offsets @ np.linalg.svd(offsets, full_matrices=False)[2][0]
        order = np.argsort(along, kind="stable")
        half = len(order) // 2
        pieces[widest : widest + 1] = [np.sort(piece[order[:half]]), np.sort(piece[order[half:]])]
    sets = [np.unique(triangles[piece]) for piece in pieces]
    return SkinHulls(
        part=np.array([joint[piece[0]] for piece in pieces], dtype=np.int64),
        first=np.concatenate([[0], np.cumsum([len(s) for s in sets])]).astype(np.int64),
        vertex=np.concatenate([*sets, np.zeros(0, dtype=np.int64)]).astype(np.int32),
    )
