"""Vertices of a skin's hulls that provably are no corners at any pose.

Vertices with equal weights are moved by one affine map, and affine maps keep convex combinations:
of such a group only the corners of its hull at rest can be corners of anything later. Pose blend
shapes move vertex i at rest by at most b_i = 2 sqrt(2) * sum over joints of |B_ij|, since no
rotation is further from the identity. A point deeper in a hull than d stays in it while corners
move by at most d (the hull's support drops by at most d in every direction), so a vertex deeper
than b_i plus the largest b of the group can be left out too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from halfphysics.body.skin_hulls import SkinHulls

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Largest |R - I| of any rotation R, by the Frobenius norm: half a turn.
FARTHEST = 2.0 * np.sqrt(2.0)


def without_inner(
    hulls: SkinHulls,
    weights: Array,
    rest_vertices: Array,
    posedirs: Array | None,
    image: Ints | None = None,
) -> SkinHulls:
    """The same hulls of fewer vertices, at every pose of this shape (not of others).

    Every face remains inside one hull, although not all its vertices remain in the set.

    Args:
        hulls: Vertex sets of whole faces.
        weights: Skinning weights, shape (V, 55).
        rest_vertices: Skin of the shape at rest [m], shape (V, 3).
        posedirs: Pose blend shapes [m], shape (V, 3, 486), or None.
        image: Of each vertex its mirror image (V,), or None. Of hulls that mirror each other, or
            themselves, a vertex stays where its image does.
    """
    moved = np.zeros(len(rest_vertices))
    if posedirs is not None:
        by_joint = posedirs.reshape(len(rest_vertices), 3, -1, 9)
        square = np.einsum("vijk,vijk->vj", by_joint, by_joint)  # the squares alone are 100 MB
        moved = FARTHEST * np.sqrt(square).sum(axis=1)
    kind = _kinds(weights)
    needed = []
    hull_sets = np.split(hulls.vertex, hulls.first[1:-1])
    for some in hull_sets:
        keep = np.ones(len(some), dtype=bool)
        for group in _groups(kind[some]):
            keep[group] = _may_be_corner(rest_vertices[some[group]], moved[some[group]])
        needed.append(keep)
    if image is not None:
        _keep_images(hull_sets, needed, image)
    sets = [some[keep] for some, keep in zip(hull_sets, needed, strict=True)]
    return SkinHulls(
        part=hulls.part.copy(),
        first=np.cumsum([0, *(len(s) for s in sets)], dtype=np.int64),
        vertex=np.concatenate([np.zeros(0, dtype=np.int32), *sets]),
    )


def _keep_images(
    sets: list[NDArray[np.int32]], needed: list[NDArray[np.bool_]], image: Ints
) -> None:
    """Of sets that mirror each other keep the same vertices, in place."""
    by_set = {np.sort(some).tobytes(): k for k, some in enumerate(sets)}
    was = [keep.copy() for keep in needed]
    for some, keep in zip(sets, needed, strict=True):
        mirrored = image[some].astype(np.int32)
        k = by_set.get(np.sort(mirrored).tobytes())
        if k is not None:
            order = np.argsort(sets[k])
            keep |= was[k][order[np.searchsorted(sets[k][order], mirrored)]]


def _kinds(rows: Array) -> NDArray[np.int64]:
    """A number for each row (n, m), shape (n,): equal rows have the same one."""
    number: dict[bytes, int] = {}
    # Zeros of either sign are equal, but not by their bytes.
    kinds = [number.setdefault(row.tobytes(), len(number)) for row in rows + 0.0]
    return np.array(kinds, dtype=np.int64)


def _groups(kind: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Indices of equal entries, groups of five and more: fewer points are all corners."""
    order = np.argsort(kind, kind="stable")
    ends = np.flatnonzero(np.diff(kind[order])) + 1
    return [group for group in np.split(order, ends) if len(group) > 4]


def _may_be_corner(points: Array, moved: Array) -> NDArray[np.bool_]:
    """Which of the points (n, 3) can be corners once each has moved by up to `moved` (n,)."""
    keep = np.ones(len(points), dtype=bool)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # flat
        return keep
    keep[:] = False
    keep[hull.vertices] = True
    need = moved + moved[hull.vertices].max()
    if need.any():
        normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
        depth = -(points @ normals.T + offsets).max(axis=1)
        keep |= depth < need
    return keep
