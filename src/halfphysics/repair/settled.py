"""Planted feet put down: a foot that is kept in place neither hovers nor sinks.

Noise lifts a sole that rests by millimetres, frame by frame. The lowest skin of a foot that is kept
in place comes to stand on the surface below it, as the core lets soles stand. The farther it is
from it the less: a foot that is being lifted slowly is on its way, and one that is deep inside
something is left to the simulation, which moves the person.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.repair.ground_fit import STANDS
from halfphysics.repair.legs import SIDES, feet_moved
from halfphysics.repair.swings import over_swings

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.repair.soles import Soles

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A foot this far over or in the surface is put onto it in whole, and this far not at all [m].
WHOLE, NONE = 0.015, 0.03


def settled(motion: Motion, body: Body, soles: Soles, held: Mask) -> Motion:
    """The motion whose resting feet stand on what is below them.

    Args:
        motion: The motion, T frames.
        body: The person's body.
        soles: Its soles.
        held: Frames in which the left and the right foot are put down (T, 2).
    """
    _, quaternion = body.joint_frames(motion)
    ankles = [JOINT_INDEX[f"{side}_ankle"] for side in SIDES]
    shift = np.zeros((len(motion), 2, 3))
    for k in range(2):
        gap = soles.gap[:, 2 * k : 2 * k + 2].min(axis=1)
        shift[:, k, 2] = np.where(held[:, k], onto(gap), 0.0)
        stands = held[:, k] | soles.rests[:, 2 * k : 2 * k + 2].any(axis=1)
        shift[:, k] = over_swings(shift[:, k], stands, soles.fps)
    return feet_moved(motion, body, shift, quaternion[:, ankles], held)


def onto(gap: Array) -> Array:
    """How far feet are shifted up (T,) [m] by the gaps under them (T,) [m]; inf: none is known."""
    near = np.abs(gap) < NONE
    gap = np.where(near, gap, NONE)
    share = np.minimum(1.0, (NONE - np.abs(gap)) / (NONE - WHOLE))
    result: Array = share * (STANDS - gap)
    return result
