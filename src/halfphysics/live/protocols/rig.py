"""The bones of a sender, and the SMPL-X joints that they turn.

A bone's frame at rest may be turned in any way against the SMPL-X joint's, whose axes at rest are
the person's: y up, z ahead, x to the left. The rest pose gives the constant turn between them,
``C = bone from SMPL-X joint``; from then on the joint's rotation is ``W(t) C``, with the bone's
rotation W in the sender's axes. `calibration` finds C by a T-pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES
from halfphysics.body.body import Body
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS, PARENTS

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: Joints whose bone goes to a certain next joint: the limbs.
LIMBS = {
    JOINT_INDEX[f"{side}_{joint}"]: JOINT_INDEX[f"{side}_{then}"]
    for side in ("left", "right")
    for joint, then in (
        ("hip", "knee"),
        ("knee", "ankle"),
        ("shoulder", "elbow"),
        ("elbow", "wrist"),
    )
}
# Bones of the sender's skeleton that are shorter have no direction [m].
_SHORT = 0.01


@dataclass(frozen=True, eq=False)
class Rig:
    """Bones and the joints that they turn.

    Attributes:
        joints: SMPL-X joint of each bone (n,). If several bones have one joint, the last that is
            given turns it, and all of them follow it.
        turns: C of each bone (n, 4).
        axes: World from sender axes (3, 3), both right-handed.
        scale: Metres of ours per metre of the sender's: the ratio of the legs.
    """

    joints: NDArray[np.intp]
    turns: Array
    axes: Array
    scale: float = 1.0

    @classmethod
    def of(
        cls, joints: Sequence[int], *, turns: ArrayLike | None = None, axes: Array = AXES["y"]
    ) -> Rig:
        """A rig whose bones have the person's axes at rest, or are turned by `turns` (n, 4)."""
        given = np.tile([1.0, 0.0, 0.0, 0.0], (len(joints), 1)) if turns is None else turns
        return cls(np.asarray(joints, dtype=np.intp), np.array(given, dtype=np.float64), axes)

    def pose(
        self, world: Array, given: Bools, pelvis: Array | None, body: Body
    ) -> tuple[Pose, Bools]:
        """The pose of a body, and the joints that the sender gives (55,).

        Joints that are not given keep their rest rotation against their parent.

        Args:
            world: Rotations of the bones in the sender's axes (n, 4).
            given: Bones that are given (n,).
            pelvis: Position of the pelvis in the sender's axes and unit (3,); None: the body
                stands at the origin.
            body: Whose pose it is.
        """
        turned, tracked = self._turned(world, given)
        above = np.maximum(PARENTS, 0)
        local = rot.multiply(rot.conjugate(turned[above]), turned)
        axes = rot.from_matrix(self.axes)
        local[0] = rot.multiply(axes, turned[0])
        if pelvis is None:
            at = np.array([0.0, 0.0, standing_height(body)])
        else:
            at = self.axes @ np.asarray(pelvis, dtype=np.float64) * self.scale
        return Pose(at - body.rest_joints[0], rot.log(local)), tracked

    def _turned(self, world: Array, given: Bools) -> tuple[Array, Bools]:
        """Rotations of the joints in the sender's axes (55, 4), and those given (55,)."""
        turned = np.empty((N_JOINTS, 4))
        tracked = np.zeros(N_JOINTS, dtype=bool)
        joints = self.joints[given]
        turned[joints] = rot.multiply(world, self.turns)[given]
        tracked[joints] = True
        if not tracked[0]:
            turned[0] = rot.from_matrix(self.axes.T @ AXES["y"])
        for joint in np.flatnonzero(~tracked[1:]) + 1:
            turned[joint] = turned[PARENTS[joint]]
        return turned, tracked

    def bones(self, quaternions: Array) -> Array:
        """Rotations of the bones in the sender's axes (n, 4) of joints in the world (55, 4)."""
        own = rot.multiply(rot.from_matrix(self.axes.T), quaternions)
        return rot.multiply(own[self.joints], rot.conjugate(self.turns))

    def places(self, positions: Array) -> Array:
        """Positions in the sender's axes and unit (..., 3) of those in the world [m]."""
        placed: Array = positions @ self.axes / self.scale
        return placed

    def aligned(self, rest: Array, rotations: Array, given: Bools, body: Body) -> Rig:
        """The same with limbs along the sender's at rest, whose arms may hang a little.

        Args:
            rest: Positions of the bones at rest in the sender's axes (n, 3).
            rotations: Their rotations at rest in the sender's axes (n, 4).
            given: Bones whose position is known (n,).
            body: Whose rest pose is the other one.
        """
        turns = np.array(self.turns)
        at = {int(joint): i for i, joint in enumerate(self.joints) if given[i]}
        for joint, then in LIMBS.items():
            if joint not in at or then not in at:
                continue
            i = at[joint]
            way = rest[at[then]] - rest[i]
            if np.linalg.norm(way) < _SHORT:
                continue
            base = rot.multiply(rotations[i], self.turns[i])
            ours = rot.rotate(base, body.rest_joints[then] - body.rest_joints[joint])
            swing = shortest(ours, way)
            turned = rot.multiply(swing, base)
            turns[i] = rot.multiply(rot.conjugate(rotations[i]), turned)
        return replace(self, turns=turns)


def standing_height(body: Body) -> float:
    """Height of the pelvis above the soles at rest [m]."""
    return float(body.rest_joints[0, 1] - body.rest_vertices[:, 1].min())


def shortest(a: Array, b: Array) -> Array:
    """The shortest rotation (4,) that turns the direction of `a` into that of `b`."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    if a @ b < -1.0 + 1e-12:
        side = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        return np.concatenate([[0.0], side / np.linalg.norm(side)])
    return rot.normalize(np.concatenate([[1.0 + a @ b], np.cross(a, b)]))
