"""A clip put on its ground: moved, turned level, and freed of a drift."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.repair.ground_fit import Ground

Array = NDArray[np.float64]


def levelled(motion: Motion, body: Body, ground: Ground) -> Motion:
    """The motion on a level ground that stays where it is.

    A drift is taken out along the vertical, then the clip is turned about the middle of where it
    stands by the least turn that makes its ground level, and moved up or down.
    """
    time = np.arange(len(motion)) / motion.fps
    translation = np.array(motion.translation)
    translation[:, 2] -= ground.height + ground.drift * (time - ground.time)
    if not any(ground.slope):
        return motion.with_frames(translation, motion.rotations)
    turn = rot.rotvec_to_matrix(_to_level(ground))
    pelvis = motion.axes @ np.asarray(body.rest_joints)[0]
    pivot = np.array([*ground.centre[:2], ground.centre[2] - ground.height])
    rotations = np.array(motion.rotations)
    rotations[:, 0] = rot.matrix_to_rotvec(turn @ rot.rotvec_to_matrix(rotations[:, 0]))
    translation = (translation + pelvis - pivot) @ turn.T + pivot - pelvis
    return motion.with_frames(translation, rotations)


def _to_level(ground: Ground) -> Array:
    """The least rotation (3,) that takes the normal of the clip's ground to the vertical."""
    normal = np.array([-ground.slope[0], -ground.slope[1], 1.0])
    axis = np.cross(normal, [0.0, 0.0, 1.0])
    result: Array = axis * (ground.tilt / np.linalg.norm(axis))
    return result
