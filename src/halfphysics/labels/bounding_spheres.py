"""Bounding spheres of the skin, by part and by cluster, in every frame.

Parts whose bounding spheres are far from all items are not skinned. Parts are tested first, as they
are few; then the small clusters of vertices of the parts that may be near.
"""

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
Whole = NDArray[np.int64]
Ints = NDArray[np.int32]

_MOST = 64  # vertices of a cluster


@dataclass(frozen=True, eq=False)
class Balls:
    """Bounding spheres of groups of a skin's vertices, without posing the skin.

    A skinned vertex is a weighted mean of its rigid positions under the joints that carry it, so it
    lies in a sphere around the spheres that move with these joints. A group's sphere contains the
    corners of all faces that reach into the group, and so these faces.

    Attributes:
        groups: Number of groups.
        joint, of: Joint and group of each sphere (k,), ordered by joint.
        centre, radius: Of the sphere in the joint's frame at rest (k, 3), (k,) [m].
        bulge: Largest displacement of a group's vertices by pose blend shapes per unit of
            |R - I| of each joint (groups, 54) [m], or None.
    """

    groups: int
    joint: Ints
    of: Ints
    centre: Array
    radius: Array
    bulge: Array | None

    def at(
        self,
        rotations: Array,
        positions: Array,
        quaternions: Array,
        wanted: NDArray[np.bool_] | None = None,
    ) -> tuple[Array, Array]:
        """Centres (T, groups, 3) and radii (T, groups) [m] in every frame; -inf: without skin.

        Args:
            rotations: Rotations of the motion (T, 55, 3).
            positions, quaternions: Of its joints, from `Body.joint_frames`.
            wanted: Groups to compute in each frame (T, groups), the others have no skin; None:
                all.
        """
        from halfphysics import _native

        if wanted is None:
            wanted = np.ones((len(positions), self.groups), dtype=bool)
        centres, radii = _native.part_balls(
            positions,
            quaternions,
            self.joint,
            self.of,
            self.centre,
            self.radius,
            wanted.view(np.uint8),
        )
        if self.bulge is not None:
            # A rotation matrix differs by this from none (Frobenius norm).
            angle = np.linalg.norm(rotations[:, 1:], axis=2)
            radii += (np.sqrt(8.0) * np.abs(np.sin(0.5 * angle))) @ self.bulge.T
        return centres, radii


@dataclass(frozen=True, eq=False)
class PartBalls:
    """A body's parts and their clusters.

    Attributes:
        part: Joint with the largest weight of every vertex (V,).
        cluster: Cluster of every vertex (V,): neighbours at rest, part by part.
        of: Part of each cluster (c,).
        order: The vertices cluster by cluster, ascending in each (V,).
        corners: The clusters of the corners of each face (3, F).
        parts, clusters: The spheres of both.
    """

    part: Whole
    cluster: Whole
    of: Whole
    order: Whole
    corners: Whole
    parts: Balls
    clusters: Balls


_known: WeakKeyDictionary[Body, PartBalls] = WeakKeyDictionary()


def part_balls(body: Body) -> PartBalls:
    """The spheres of a body; computed once."""
    found = _known.get(body)
    if found is None:
        found = _known[body] = _made(body)
    return found


def _made(body: Body) -> PartBalls:
    part = np.asarray(body.weights.argmax(axis=1))
    pieces = [
        piece
        for p in range(N_JOINTS)
        for piece in _split(body.rest_vertices, np.flatnonzero(part == p))
    ]
    cluster = np.empty(len(part), dtype=np.int64)
    for index, piece in enumerate(pieces):
        cluster[piece] = index
    return PartBalls(
        part=part,
        cluster=cluster,
        of=np.array([part[piece[0]] for piece in pieces]),
        order=np.argsort(cluster, kind="stable"),
        corners=np.ascontiguousarray(cluster[body.faces].T),
        parts=_balls(body, part, N_JOINTS),
        clusters=_balls(body, cluster, len(pieces)),
    )


def _split(points: Array, some: Whole) -> list[Whole]:
    """Divide vertices along their longest side until the clusters are small."""
    if len(some) <= _MOST:
        return [some] if len(some) else []
    mine = points[some]
    along = mine[:, np.ptp(mine, axis=0).argmax()].argsort(kind="stable")
    half = len(some) // 2
    return _split(points, some[along[:half]]) + _split(points, some[along[half:]])


def _balls(body: Body, group: Whole, groups: int) -> Balls:
    """The spheres of groups, given the group of each vertex (V,)."""
    count = len(group)
    # Every group with its own vertices, and with those of faces that reach into it.
    pairs = [group * count + np.arange(count)]
    for corner in range(3):
        for other in range(3):
            pairs.append(group[body.faces[:, corner]] * count + body.faces[:, other])
    of, vertex = np.divmod(np.unique(np.concatenate(pairs)), count)
    # And each of these vertices with every joint that carries it.
    first, joints, _ = body.skin.sparse_weights
    many = np.diff(first)[vertex]
    entry = np.arange(many.sum()) + np.repeat(first[vertex] - np.cumsum(many) + many, many)
    joint = joints[entry]
    points = body.rest_vertices[np.repeat(vertex, many)] - body.rest_joints[joint]
    key = joint.astype(np.int64) * groups + np.repeat(of, many)
    order = np.argsort(key, kind="stable")
    points, key = points[order], key[order]
    start = np.flatnonzero(np.diff(key, prepend=-1))
    centre = 0.5 * (np.minimum.reduceat(points, start) + np.maximum.reduceat(points, start))
    apart = points - np.repeat(centre, np.diff(start, append=len(key)), axis=0)
    # Rounding of the skinning itself is far below this.
    radius = np.maximum.reduceat(np.linalg.norm(apart, axis=1), start) + 1e-9
    return Balls(
        groups=groups,
        joint=(key[start] // groups).astype(np.int32),
        of=(key[start] % groups).astype(np.int32),
        centre=centre,
        radius=radius,
        bulge=_bulge(body, of, vertex, groups),
    )


def _bulge(body: Body, of: Whole, vertex: Whole, groups: int) -> Array | None:
    if body.posedirs is None:
        return None
    shapes = body.posedirs.reshape(len(body.rest_vertices), 3, N_JOINTS - 1, 9)
    norms = np.linalg.norm(shapes, axis=(1, 3))
    bulge = np.zeros((groups, N_JOINTS - 1))
    start = np.flatnonzero(np.diff(of, prepend=-1))
    bulge[of[start]] = np.maximum.reduceat(norms[vertex], start)
    return bulge
