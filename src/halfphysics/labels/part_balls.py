"""Balls around the skin of each part in every frame: what is far from them need not be skinned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PartBalls:
    """What is known of a body's parts before it is posed.

    A skinned vertex is a mean of where the joints that carry it would take it: it lies in a ball
    around the balls that these joints take along.

    Attributes:
        part: Of every vertex, the joint with its largest weight (V,).
        pair_part, pair_joint: Parts and the joints that carry some of their vertices (k,).
        centre: Of those vertices, in that joint's frame at rest (k, 3) [m].
        radius: Of the ball around them (k,) [m].
        own: Of every part with vertices the pair with its own joint (55,), -1 where it has none.
        bulge: How far pose blend shapes move a part's vertices for every unit by which a joint's
            rotation differs from none (55, 54) [m], or None.
    """

    part: NDArray[np.int64]
    pair_part: NDArray[np.int64]
    pair_joint: NDArray[np.int64]
    centre: Array
    radius: Array
    own: NDArray[np.int64]
    bulge: Array | None

    def at(self, body: Body, motion: Motion) -> tuple[Array, Array]:
        """Centres (T, 55, 3) and radii (T, 55) [m] in every frame; -inf: a part without skin."""
        positions, quaternions = body.joint_frames(motion)
        turns = rot.to_matrix(quaternions)
        carried = positions[:, self.pair_joint] + np.einsum(
            "tkij,kj->tki", turns[:, self.pair_joint], self.centre
        )
        count = len(positions)
        centres, radii = np.zeros((count, N_JOINTS, 3)), np.full((count, N_JOINTS), -np.inf)
        there = self.own >= 0
        centres[:, there] = carried[:, self.own[there]]
        apart = np.linalg.norm(carried - centres[:, self.pair_part], axis=2) + self.radius
        if len(self.pair_part):
            first = np.flatnonzero(np.diff(self.pair_part, prepend=-1))
            radii[:, self.pair_part[first]] = np.maximum.reduceat(apart, first, axis=1)
        if self.bulge is not None:
            local = rot.rotvec_to_matrix(motion.rotations[:, 1:]) - np.eye(3)
            radii += np.linalg.norm(local, axis=(2, 3)) @ self.bulge.T
        return centres, radii


_known: WeakKeyDictionary[Body, PartBalls] = WeakKeyDictionary()


def part_balls(body: Body) -> PartBalls:
    """Of a body; worked out once."""
    found = _known.get(body)
    if found is None:
        found = _known[body] = _made(body)
    return found


def _made(body: Body) -> PartBalls:
    part = np.asarray(body.weights.argmax(axis=1))
    parts: list[int] = []
    joints: list[int] = []
    centres: list[Array] = []
    radii: list[float] = []
    own = np.full(N_JOINTS, -1)
    for p in range(N_JOINTS):
        mine = np.flatnonzero(part == p)
        for j in np.flatnonzero((body.weights[mine] > 0.0).any(axis=0)):
            carried = body.rest_vertices[mine[body.weights[mine, j] > 0.0]] - body.rest_joints[j]
            centre = 0.5 * (carried.min(axis=0) + carried.max(axis=0))
            if j == p:
                own[p] = len(parts)
            parts.append(p)
            joints.append(int(j))
            centres.append(centre)
            # Rounding of the skinning itself is far below this.
            radii.append(float(np.linalg.norm(carried - centre, axis=1).max()) + 1e-9)
    bulge = None
    if body.posedirs is not None:
        norms = np.linalg.norm(body.posedirs.reshape(len(part), 3, N_JOINTS - 1, 9), axis=(1, 3))
        bulge = np.zeros((N_JOINTS, N_JOINTS - 1))
        np.maximum.at(bulge, part, norms)
    return PartBalls(
        part=part,
        pair_part=np.array(parts, dtype=np.int64),
        pair_joint=np.array(joints, dtype=np.int64),
        centre=np.array(centres).reshape(-1, 3),
        radius=np.array(radii),
        own=own,
        bulge=bulge,
    )
