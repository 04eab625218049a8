"""Balls around the skin of each part in every frame: what is far from them need not be skinned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from halfphysics.skeleton import N_JOINTS

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class PartBalls:
    """What is known of a body's parts before it is posed.

    A skinned vertex is a mean of where the joints that carry it would take it: it lies in a ball
    around the balls that these joints take along. A part's ball has the corners of all faces that
    reach into the part in it, and so these faces.

    Attributes:
        part: Of every vertex, the joint with its largest weight (V,).
        order: The vertices part by part, ascending in each (V,).
        joint, of: Which joint carries some vertices of which part (k,), joint by joint.
        centre, radius: Of the ball around these in the joint's frame at rest (k, 3), (k,) [m].
        bulge: How far pose blend shapes move a part's vertices for every unit by which a joint's
            rotation differs from none (55, 54) [m], or None.
    """

    part: Whole
    order: Whole
    joint: Ints
    of: Ints
    centre: Array
    radius: Array
    bulge: Array | None

    def at(self, motion: Motion, positions: Array, quaternions: Array) -> tuple[Array, Array]:
        """Centres (T, 55, 3) and radii (T, 55) [m] in every frame; -inf: a part without skin.

        Args:
            motion: How the body moves.
            positions, quaternions: Of its joints, as `Body.joint_frames` says.
        """
        from halfphysics import _native

        centres, radii = _native.part_balls(
            positions, quaternions, self.joint, self.of, self.centre, self.radius
        )
        if self.bulge is not None:
            # A rotation matrix differs by this from none (Frobenius norm).
            angle = np.linalg.norm(motion.rotations[:, 1:], axis=2)
            radii += (np.sqrt(8.0) * np.abs(np.sin(0.5 * angle))) @ self.bulge.T
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
    carried: list[tuple[int, int, Array, float]] = []
    for p in range(N_JOINTS):
        reaching = body.faces[(of_face == p).any(axis=1)]
        mine = np.union1d(np.flatnonzero(part == p), reaching)
        for joint in np.flatnonzero((weights[mine] > 0.0).any(axis=0)):
            points = rest[mine[weights[mine, joint] > 0.0]] - body.rest_joints[joint]
            centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
            # Rounding of the skinning itself is far below this.
            radius = float(np.linalg.norm(points - centre, axis=1).max()) + 1e-9
            carried.append((int(joint), p, centre, radius))
    joints, parts, centres, radii = zip(*sorted(carried, key=lambda one: one[:2]), strict=True)
    return PartBalls(
        part=part,
        order=np.argsort(part, kind="stable"),
        joint=np.array(joints, dtype=np.int32),
        of=np.array(parts, dtype=np.int32),
        centre=np.array(centres),
        radius=np.array(radii),
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
