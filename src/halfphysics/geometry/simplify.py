"""Fewer triangles for a closed mesh: edges are collapsed where the surface hardly moves.

Quadric error metrics (Garland and Heckbert 1997): a vertex knows the planes of the triangles that
were collapsed into it, and an edge collapses to the place with the least mean squared distance to
the planes of both ends. Here many edges collapse at once: of the cheapest ones as many as share no
triangle with each other.

An edge collapses only where the surface stays a manifold (its ends have two common neighbours) and
no triangle turns over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: Pull of an edge's middle on the place to which it collapses, as a share of the planes': in flat
#: regions nothing else determines it.
_MIDDLE = 1e-3
#: Least cosine between the normals of a triangle before and after a collapse.
_TURN = 0.2
#: Rounds of collapses: each takes a twelfth of the vertices or less.
_MOST_ROUNDS = 100
#: Share of the edges, the cheapest ones, that may collapse in a round.
_CHEAP = 0.4


def is_manifold(faces: NDArray[np.integer]) -> bool:
    """Whether every edge belongs to exactly two triangles (F, 3), which run it either way."""
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    if len(np.unique(directed, axis=0)) < len(directed):
        return False
    return bool((np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)[1] == 2).all())


def simplified(mesh: Mesh, triangles: int, tolerance: float) -> Mesh:
    """The mesh with about so many triangles, or as few as the tolerance allows.

    Args:
        mesh: Closed, every edge with two triangles (`is_manifold`).
        triangles: Number at which it ends.
        tolerance: Largest root mean square distance [m] of a vertex to the planes it stands for.
    """
    vertices, faces = np.array(mesh.vertices), mesh.faces.astype(np.int64)
    quadric = _quadrics(vertices, faces)
    for round_ in range(_MOST_ROUNDS):
        spare = (len(faces) - triangles) // 2
        if spare <= 0:
            break
        ends, place, cost = _collapses(vertices, faces, quadric, tolerance)
        if not len(cost):
            break
        cheap = cost <= np.quantile(cost, _CHEAP)
        ends, place, cost = ends[cheap], place[cheap], cost[cheap]
        # In any order, another in every round: an edge that turns a triangle over would hold back
        # those about it for ever.
        rank = np.random.default_rng(round_).permutation(len(cost))
        chosen = _apart(faces, len(vertices), ends, rank)
        chosen = chosen[_keeps_side(vertices, faces, ends[chosen], place[chosen])]
        chosen = chosen[np.argsort(cost[chosen], kind="stable")][:spare]
        if not len(chosen):
            break
        keep, gone = ends[chosen].T
        vertices[keep] = place[chosen]
        quadric[keep] += quadric[gone]
        to = np.arange(len(vertices))
        to[gone] = keep
        faces = to[faces]
        whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        faces = faces[whole]
        used, faces = np.unique(faces, return_inverse=True)
        faces = faces.reshape(-1, 3)
        vertices, quadric = vertices[used], quadric[used]
    return Mesh(vertices, faces.astype(np.int32))


def _quadrics(vertices: Array, faces: Indices) -> Array:
    """Per vertex the sum (4, 4) of area * plane plane^T of its triangles, planes (n, -n.p)."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    unit = normal / np.maximum(area, 1e-300)[:, None]
    plane = np.concatenate([unit, -np.einsum("fi,fi->f", unit, a)[:, None]], axis=1)
    each = (area[:, None, None] * plane[:, :, None] * plane[:, None]).reshape(-1, 16)
    total = np.stack(
        [
            sum(np.bincount(faces[:, k], column, len(vertices)) for k in range(3))
            for column in each.T
        ],
        axis=1,
    )
    return total.reshape(-1, 4, 4)


def _collapses(
    vertices: Array, faces: Indices, quadric: Array, tolerance: float
) -> tuple[Indices, Array, Array]:
    """The edges (n, 2) that may collapse, where to (n, 3), and the mean squared distance (n,)."""
    from scipy.sparse import coo_array

    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ends = directed[directed[:, 0] < directed[:, 1]]
    count = len(vertices)
    ones = np.ones(len(directed), dtype=np.int32)
    near = coo_array((ones, (directed[:, 0], directed[:, 1])), shape=(count, count)).tocsr()
    common = np.asarray((near @ near)[ends[:, 0], ends[:, 1]]).reshape(-1)
    ends = ends[common == 2]
    both = quadric[ends[:, 0]] + quadric[ends[:, 1]]
    weight = np.trace(both[:, :3, :3], axis1=1, axis2=2)  # the area: normals have unit length
    middle = 0.5 * (vertices[ends[:, 0]] + vertices[ends[:, 1]])
    pull = (_MIDDLE * weight)[:, None, None] * np.eye(3)
    # Relative to the middle: no cancellation far from the origin.
    slope = np.einsum("nij,nj->ni", both[:, :3, :3], middle) + both[:, :3, 3]
    step = np.linalg.solve(both[:, :3, :3] + pull + 1e-300 * np.eye(3), -slope[..., None])[..., 0]
    place = middle + step
    point = np.concatenate([place, np.ones((len(place), 1))], axis=1)
    cost = np.einsum("ni,nij,nj->n", point, both, point) / np.maximum(weight, 1e-300)
    cost = np.maximum(cost, 0.0)
    short = np.linalg.norm(step, axis=1) <= np.linalg.norm(
        vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1
    )
    fine = short & (cost <= tolerance**2)
    return ends[fine], place[fine], cost[fine]


def _apart(faces: Indices, count: int, ends: Indices, rank: Indices) -> Indices:
    """Indices of edges of which each has the lowest rank of all that touch its triangles."""
    last = len(rank)
    at_vertex = np.full(count, last)
    for k in range(2):
        np.minimum.at(at_vertex, ends[:, k], rank)
    at_face = at_vertex[faces].min(axis=1)
    around = np.full(count, last)
    for k in range(3):
        np.minimum.at(around, faces[:, k], at_face)
    return np.flatnonzero((around[ends[:, 0]] == rank) & (around[ends[:, 1]] == rank))


def _keeps_side(vertices: Array, faces: Indices, ends: Indices, place: Array) -> NDArray[np.bool_]:
    """Whether each edge (n, 2) may collapse to its place without turning a triangle over."""
    edge_of = np.full(len(vertices), -1)
    edge_of[ends[:, 0]] = edge_of[ends[:, 1]] = np.arange(len(ends))
    mine = edge_of[faces]
    some = np.flatnonzero((mine >= 0).any(axis=1))
    moved = np.where((mine[some] >= 0)[..., None], place[mine[some]], vertices[faces[some]])
    before, after = _normals(vertices[faces[some]]), _normals(moved)
    # Triangles at the edge itself vanish.
    stays = (mine[some] >= 0).sum(axis=1) == 1
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    turned = stays & (np.einsum("fi,fi->f", before, after) <= _TURN * lengths)
    fine = np.ones(len(ends), dtype=bool)
    fine[mine[some][turned].max(axis=1)] = False
    return fine


def _normals(corners: Array) -> Array:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
