"""Planes between many pairs of convex sets at once: a plane that separates two sets is a proof.

A pair is a cloud of points and a convex obstacle. For a unit normal n, pointing from the obstacle
to the cloud, the distance of the pair is at least

    d(n) = min over the cloud of p . n  -  max over the obstacle of q . n.

`planes` looks for the n with the largest d by GJK: the difference of the two sets is searched for
its point nearest to the origin, with a triangle of its points that moves toward it. However n was
found, d(n) is right by itself: the search can only miss a plane, never invent one.
"""

from __future__ import annotations

import numpy as np

from support import short_rows as rows

#: Steps of the search, and the accuracy at which it ends [m].
STEPS, ACCURACY = 14, 1e-7
#: Lengths under this have no direction [m].
TINY = 1e-12


def planes(clouds, highest, guess, far, settle=False):
    """Unit normals (K, 3) and the distances d(n) that they prove (K,) [m].

    Args:
        clouds: The points of each pair (K, m, 3) [m].
        highest: (pairs (k,), unit normals (k, 3)) -> the obstacles' points that are farthest along
            the normals (k, 3).
        guess: The first directions that are tried (K, 3).
        far: A pair's search ends when this distance is proven [m],
        settle: or disproven; with `settle` only at the largest d.
    """
    normal, proven = np.zeros((len(clouds), 3)), np.full(len(clouds), -np.inf)
    pair, nearest, triangle = np.arange(len(clouds)), guess, None
    for _ in range(STEPS):
        size = rows.length(nearest)
        n = nearest / np.maximum(size, TINY)[:, None]
        heights = (clouds @ n[:, :, None])[:, :, 0]
        low = clouds[np.arange(len(pair)), heights.argmin(axis=1)]
        newest = low - highest(pair, n)
        d = np.einsum("ki,ki->k", newest, n)
        better = (d > proven[pair]) & (size > TINY)  # without a direction nothing is proven
        normal[pair[better]], proven[pair[better]] = n[better], d[better]
        if triangle is None:
            triangle, nearest = np.repeat(newest[:, None], 3, axis=1), newest
        else:
            triangle, nearest = _nearer(triangle, newest)
        size = rows.length(nearest)  # the distance is not larger
        left = (proven[pair] < far) & (size - proven[pair] > ACCURACY)
        left &= size > (TINY if settle else far)
        if not left.any():
            break
        if not left.all():
            pair, clouds, triangle, nearest = (
                pair[left],
                clouds[left],
                triangle[left],
                nearest[left],
            )
    return normal, proven


def _nearer(triangle, point):
    """Of the tetrahedra of triangles (k, 3, 3) and points (k, 3): the side with the point nearest
    to the origin, among those at the point; and that nearest point (k, 3)."""
    sides = np.empty((len(point), 3, 3, 3))  # (k, side, corner, 3)
    sides[:, :, 0] = point[:, None]
    sides[:, :, 1], sides[:, :, 2] = triangle, triangle[:, [1, 2, 0]]
    at = nearest_to_origin(sides.reshape(-1, 3, 3)).reshape(-1, 3, 3)
    best = np.einsum("ksi,ksi->ks", at, at).argmin(axis=1)
    pair = np.arange(len(point))
    return sides[pair, best], at[pair, best]


def nearest_to_origin(triangles):
    """The points (k, 3) of triangles (k, 3, 3) that are nearest to the origin."""
    edges = triangles[:, [1, 2, 0]] - triangles
    length = np.einsum("kei,kei->ke", edges, edges)
    share = -np.einsum("kei,kei->ke", triangles, edges) / np.where(length > 0.0, length, 1.0)
    on_edge = triangles + np.clip(share, 0.0, 1.0)[..., None] * edges
    edge = np.einsum("kei,kei->ke", on_edge, on_edge).argmin(axis=1)
    out = on_edge[np.arange(len(edge)), edge]
    up = rows.cross(edges[:, 0], edges[:, 1])
    area = np.einsum("ki,ki->k", up, up)
    turns = rows.cross(triangles.reshape(-1, 3), edges.reshape(-1, 3)).reshape(triangles.shape)
    inside = (area > 0.0) & (rows.smallest(np.einsum("kei,ki->ke", turns, up)) >= 0.0)
    height = np.einsum("ki,ki->k", triangles[:, 0], up) / np.where(inside, area, 1.0)
    out[inside] = (height[:, None] * up)[inside]
    return out
