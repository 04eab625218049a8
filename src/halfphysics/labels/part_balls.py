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
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class PartBalls:
    """What is known of a body's parts before it is posed.

    A skinned vertex is a mean of where the joints that carry it would take it: it lies in a ball
    around the balls that these joints take along. A part's ball has the corners of all faces that
    reach into the part in it, and so these faces.

    Attributes:
        part: Of every vertex, the joint with its largest weight (V,).
        order: The vertices part by part, ascending in each (V,).
        pairs: Of every joint the parts of which it carries some vertices (k,), and the ball around
            these in its frame at rest: centre (k, 3) and radius (k,) [m].
        bulge: How far pose blend shapes move a part's vertices for every unit by which a joint's
            rotation differs from none (55, 54) [m], or None.
    """

    part: Whole
    order: Whole
    pairs: tuple[tuple[Whole, Array, Array], ...]
    bulge: Array | None

    def at(self, body: Body, motion: Motion) -> tuple[Array, Array]:
        """Centres (T, 55, 3) and radii (T, 55) [m] in every frame; -inf: a part without skin."""
        positions, quaternions = body.joint_frames(motion)
        turns = rot.to_matrix(quaternions)
        carried = [
            np.matmul(centre, turns[:, joint].transpose(0, 2, 1)) + positions[:, joint, None]
            for joint, (_, centre, _) in enumerate(self.pairs)
        ]
        low, high = np.full(positions.shape, np.inf), np.full(positions.shape, -np.inf)
        for at, (parts, _, _) in zip(carried, self.pairs, strict=True):
            low[:, parts] = np.minimum(low[:, parts], at)
            high[:, parts] = np.maximum(high[:, parts], at)
        with np.errstate(invalid="ignore"):  # of a part without skin
            centres = 0.5 * (low + high)
        radii = np.full(positions.shape[:2], -np.inf)
        for at, (parts, _, radius) in zip(carried, self.pairs, strict=True):
            apart = at - centres[:, parts]
            reach = np.sqrt(np.einsum("tki,tki->tk", apart, apart)) + radius
            radii[:, parts] = np.maximum(radii[:, parts], reach)
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
    rest, weights = body.rest_vertices, body.weights
    part = np.asarray(weights.argmax(axis=1))
    of_face = part[body.faces]
    carried: list[list[tuple[int, Array, float]]] = [[] for _ in range(N_JOINTS)]
    for p in range(N_JOINTS):
        reaching = body.faces[(of_face == p).any(axis=1)]
        mine = np.union1d(np.flatnonzero(part == p), reaching)
        for joint in np.flatnonzero((weights[mine] > 0.0).any(axis=0)):
            points = rest[mine[weights[mine, joint] > 0.0]] - body.rest_joints[joint]
            centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
            # Rounding of the skinning itself is far below this.
            radius = float(np.linalg.norm(points - centre, axis=1).max()) + 1e-9
            carried[joint].append((p, centre, radius))
    return PartBalls(
        part=part,
        order=np.argsort(part, kind="stable"),
        pairs=tuple(
            (
                np.array([p for p, _, _ in some], dtype=np.int64),
                np.array([centre for _, centre, _ in some]).reshape(-1, 3),
                np.array([radius for _, _, radius in some]),
            )
            for some in carried
        ),
        bulge=_bulge(body, of_face),
    )


def _bulge(body: Body, of_face: Whole) -> Array | None:
    if body.posedirs is None:
        return None
    shapes = body.posedirs.reshape(len(body.rest_vertices), 3, N_JOINTS - 1, 9)
    norms = np.linalg.norm(shapes, axis=(1, 3))
    of_faces = norms[body.faces].max(axis=1)
    bulge = np.zeros((N_JOINTS, N_JOINTS - 1))
    for corner in range(3):
        np.maximum.at(bulge, of_face[:, corner], of_faces)
    return bulge
