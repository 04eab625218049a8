"""Calibration by a T-pose: what the sender's bones look like at rest, and how tall it is.

The person stands upright, legs straight, arms to the sides, palms down, looks ahead. Then the
constant turns of `Rig` are what makes this SMPL-X's rest pose, and the ratio of the heights of
the pelvis is the scale. Which way the person looks is told by the hips, if the sender gives their
places, else by the pelvis.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.axes import AXES
from halfphysics.body.body import Body
from halfphysics.live.protocols.rig import Rig, standing_height

Array = NDArray[np.float64]

#: Heights of a pelvis that a standing person has [m]; others say that the sender gives none.
HEIGHTS = (0.3, 1.6)


def calibrated(
    rig: Rig,
    world: Array,
    body: Body,
    *,
    height: float | None = None,
    left: Array | None = None,
) -> Rig:
    """The rig of a sender whose person stands in a T-pose now.

    Args:
        rig: As it was so far.
        world: Rotations of the bones in the sender's axes (n, 4).
        body: Whose rest pose it is.
        height: Height of the sender's pelvis above the floor [m]; None: not known.
        left: From the right to the left hip in the sender's axes (3,); None: not known.
    """
    own = rot.multiply(world[0], rig.turns[0])
    side = rot.rotate(own, [1.0, 0.0, 0.0]) if left is None else left
    up = rig.axes.T @ np.array([0.0, 0.0, 1.0])
    facing = _upright(side, up, rot.from_matrix(rig.axes.T @ AXES["y"]))
    turns = rot.multiply(rot.conjugate(world), facing)
    known = height is not None and HEIGHTS[0] < height < HEIGHTS[1]
    scale = standing_height(body) / height if known and height is not None else rig.scale
    return replace(rig, turns=turns, scale=scale)


def _upright(left: Array, up: Array, otherwise: Array) -> Array:
    """Rotation (4,) of an upright person at rest whose left is nearest to `left`."""
    level = left - up * (up @ left)
    if np.linalg.norm(level) < 1e-6:
        return otherwise
    x = level / np.linalg.norm(level)
    return rot.from_matrix(np.stack([x, up, np.cross(x, up)], axis=1))
