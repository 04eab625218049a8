"""Balls around the skin of each part in every frame: what is far from them need not be skinned.

Parts first, as they are few; of those that may be near, the small clusters of their vertices.
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
    """What is known of groups of a skin's vertices before it is posed.

    A skinned vertex is a mean of where the joints that carry it would take it: it lies in a ball
    around the balls that these joints take along. A group's ball has the corners of all faces that
    reach into the group in it, and so these faces.

    Attributes:
        groups: How many there are.
        joint, of: Which joint carries some vertices of which group (k,), joint by joint.
        centre, radius: Of the ball around these in the joint's frame at rest (k, 3), (k,) [m].
        bulge: How far pose blend shapes move a group's vertices for every unit by which a joint's
            rotation differs from none (groups, 54) [m], or None.
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
            rotations: How the body moves, as `Motion.rotations` (T, 55, 3).
            positions, quaternions: Of its joints, as `Body.joint_frames` says.
            wanted: Of which groups in which frames (T, groups), the others come as without skin;
                None: of all.
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
        part: Of every vertex, the joint with its largest weight (V,).
        cluster: Of every vertex (V,): clusters are neighbours at rest, part by part.
        of: The part of each cluster (c,).
        order: The vertices cluster by cluster, ascending in each (V,).
        corners: The clusters of the corners of each face (3, F).
        parts, clusters: The balls of both.
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
    """Of a body; worked out once."""
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
    """Some vertices in halves, along their longest side, until none are many."""
    if len(some) <= _MOST:
        return [some] if len(some) else []
    mine = points[some]
    along = mine[:, np.ptp(mine, axis=0).argmax()].argsort(kind="stable")
    half = len(some) // 2
    return _split(points, some[along[:half]]) + _split(points, some[along[half:]])


def _balls(body: Body, group: Whole, groups: int) -> Balls:
    """Of the groups that each vertex is in (V,)."""
    count = len(group)
    # Every group with its own vertices, and with those of faces that reach into it.
    pairs = [group * count + np.arange(count)]
    for corner in range(3):
        for other in range(3):
            pairs.append(group[body.faces[:, corner]] * count + body.faces[:, other])
    of, vertex = np.divmod(np.unique(np.concatenate(pairs)), count)
    # And these with every joint that carries them.
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
