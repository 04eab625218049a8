"""Samples of the skin: vertices with areas, by which a person presses on what is soft.

Every vertex of the skin that can be reached gives its share of the triangles around it to the
nearest sample of its part that faces the same way: areas sum to that skin's area at rest, part by
part. Skin that lies in a fold presses nothing, as little as it would a mat: both sides of the cleft
between the buttocks would count for the same square centimetres of a seat. Samples of the right are
mirror images of those of the left (`body/symmetry.py`), where the skin is its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.body.symmetry import FLIP, Symmetry
from halfphysics.geometry.mesh_queries import MeshQuery
from halfphysics.motion.joint_groups import JOINT_GROUPS
from halfphysics.motion.skeleton import JOINT_NAMES, MIRRORED

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

#: Samples of one part are no nearer to each other [m]: a seat of 0.12 m^2 has some 200 of them.
#: With 12 to 20 mm peaks, means and areas of who sits or lies differ by up to 3 %; at 24 mm the
#: area of who lies is 5 % larger.
PITCH = 0.020
#: Of hands and feet: a sole has some 100, a fingertip a few.
FINE = 0.008
#: A ball of this radius rolls over the skin [m]: where it stays off by more than the share of that,
#: skin is in a fold. Not of hands and feet, whose folds open.
BALL, IN_A_FOLD = 0.015, 0.3

_known: WeakKeyDictionary[Body, SkinSamples] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class SkinSamples:
    """Samples of the skin, ordered by part.

    Attributes:
        vertex: Indices into the skin (n,).
        area: At rest (n,) [m^2].
        normal: Unit, outward, at rest (n, 3), rest frame.
        part: Index into `JOINT_NAMES` of each (n,).
    """

    vertex: Ints
    area: Array
    normal: Array
    part: Ints

    def __len__(self) -> int:
        return len(self.vertex)


def skin_samples(body: Body) -> SkinSamples:
    """The samples of a body; made once per body."""
    if body not in _known:
        _known[body] = _made(body)
    return _known[body]


def vertex_areas(vertices: Array, faces: NDArray[np.int32]) -> tuple[Array, Array]:
    """A third of the triangles around each vertex (V,) [m^2], and their area vectors (V, 3)."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    across = np.cross(b - a, c - a) / 6.0
    area = np.linalg.norm(across, axis=1)
    total, way = np.zeros(len(vertices)), np.zeros_like(vertices)
    for corner in faces.T:
        total += np.bincount(corner, area, len(vertices))
        for k in range(3):
            way[:, k] += np.bincount(corner, across[:, k], len(vertices))
    return total, way


def _unit(way: Array) -> Array:
    result: Array = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
    return result


def reachable(body: Body) -> NDArray[np.bool_]:
    """Which vertices of the skin at rest are in no fold (V,).

    A ball of radius `BALL` [m] that lies on such a vertex, its centre along the normal, comes no
    nearer to other skin than 1 - `IN_A_FOLD` of that: a closing by a ball (Serra 1982), vertex by
    vertex. Both of a pair of mirror images are, or none; hands and feet have no folds.
    """
    rest, faces = body.rest_vertices, body.faces
    centre = rest + BALL * _unit(vertex_areas(rest, faces)[1])
    distance, _, _ = MeshQuery(rest, faces).closest(centre)
    fine = _hands_and_feet()[body.weights.argmax(axis=1)]
    result: NDArray[np.bool_] = (distance >= (1.0 - IN_A_FOLD) * BALL) | fine
    if body.symmetry is not None:
        result |= result[body.symmetry.vertex]
    return result


def _hands_and_feet() -> NDArray[np.bool_]:
    """Which parts are of a hand or a foot (55,)."""
    return np.isin(JOINT_NAMES, JOINT_GROUPS["hands"] + JOINT_GROUPS["feet"])


def _pitches() -> Array:
    """Pitch of every part (55,) [m]."""
    return np.where(_hands_and_feet(), FINE, PITCH)


def _made(body: Body) -> SkinSamples:
    rest = body.rest_vertices
    area, way = vertex_areas(rest, body.faces)
    area[~reachable(body)] = 0.0
    unit = _unit(way)
    part = body.weights.argmax(axis=1)
    symmetry = body.symmetry
    if symmetry is not None and (part[symmetry.vertex] != MIRRORED[part]).any():
        symmetry = None
    chosen_of = _chosen(body, area, unit, part, symmetry)
    used = np.flatnonzero(area > 0.0)
    vertex, group = np.unique(chosen_of[used], return_inverse=True)
    total: Array = np.bincount(group, area[used], len(vertex)).astype(np.float64)
    normal: Array = np.zeros((len(vertex), 3))
    for k in range(3):
        normal[:, k] = np.bincount(group, way[used, k], len(vertex))
    if symmetry is not None and symmetry.is_exact(rest):
        # What lies between two samples of the middle is both's.
        other = _partners(vertex, symmetry.vertex)
        total = 0.5 * (total + total[other])
        normal = 0.5 * (normal + normal[other] * FLIP)
    short = np.linalg.norm(normal, axis=1) < 1e-3 * total
    normal[short] = unit[vertex[short]]
    order = np.lexsort((vertex, part[vertex]))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return SkinSamples(
        vertex[order].astype(np.int32),
        total[order],
        normal[order],
        part[vertex[order]].astype(np.int32),
    )


def _chosen(
    body: Body, area: Array, unit: Array, part: NDArray[np.int64], symmetry: Symmetry | None
) -> NDArray[np.int64]:
    """Of each vertex its sample (V,); of a vertex without area any."""
    from scipy.spatial import cKDTree

    rest, pitch = body.rest_vertices, _pitches()
    image = np.arange(len(rest)) if symmetry is None else symmetry.vertex
    # What can touch: the vertices that the hulls of the skin have.
    able = np.zeros(len(rest), dtype=bool)
    able[body.skin_corners.vertex] = True
    able |= able[image]
    chosen_of = np.zeros(len(rest), dtype=np.int64)
    for k in np.unique(part):
        if symmetry is not None and MIRRORED[k] < k:
            continue  # as on the left
        own = np.flatnonzero((part == k) & (area > 0.0))
        some = own[able[own]]
        if not len(own):
            continue
        some = some if len(some) else own
        # Six more coordinates keep the two sides of something thin apart.
        where = np.concatenate([rest, 2.0 * pitch[k] * unit], axis=1)
        middle = symmetry is not None and MIRRORED[k] == k
        some = some[_apart(where[some], pitch[k], _partners(some, image) if middle else None)]
        chosen_of[own] = some[cKDTree(where[some]).query(where[own])[1]]
        if symmetry is not None and not middle:
            chosen_of[image[own]] = image[chosen_of[own]]
    return chosen_of


def _partners(vertex: NDArray[np.int64], image: NDArray[np.int64]) -> NDArray[np.int64]:
    """Of each vertex, ascending (n,), where its mirror image is among them."""
    found: NDArray[np.int64] = np.searchsorted(vertex, image[vertex])
    return found


def _apart(
    points: Array, pitch: float, partner: NDArray[np.int64] | None = None
) -> NDArray[np.int64]:
    """Indices of points (n, d), in their order, none within `pitch` of one before it.

    With partners (n,) those of what is kept are kept too, what is its own partner first. What is
    too near to its partner is left out.
    """
    from scipy.spatial import cKDTree

    near = cKDTree(points).query_ball_point(points, pitch)
    free = np.ones(len(points), dtype=bool)
    kept = []
    order = np.arange(len(points))
    if partner is not None:
        order = np.argsort(partner != order, kind="stable")
    for i in order.tolist():
        j = i if partner is None else int(partner[i])
        if not free[i] or (j != i and j in near[i]):
            continue
        kept += [i] if i == j else [i, j]
        free[near[i]] = free[near[j]] = False
    return np.array(kept, dtype=np.int64)
