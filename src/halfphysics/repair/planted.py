"""Planted feet: a sole that rests stays where it is, by the leg.

While a heel or a toe rests it keeps one place, on the ground; where the load goes from heel to toe,
the toe keeps the place at which it was when it came to rest. Each foot is shifted by what that
takes, and back onto its own way while it swings; the leg follows by hip, knee and ankle. Where both
heel and toe rest, the foot keeps its rotation as well, as far as noise turns it (`steadied`). What
was kept in place is then put down (`settled`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.repair.legs import SIDES, feet_moved
from halfphysics.repair.steadied import steadied
from halfphysics.repair.swings import over_swings, runs

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.repair.soles import Soles

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A foot is shifted by no more than this [m]: beyond, its rest was none.
MOST = 0.15
#: Less than this is how soles roll and give, not damage: over a whole rest, from its mean [m].
LEAST = 0.008
#: What slides this near the ends of a rest is a foot that is set down or lifted [s]; at each end at
#: most this part of the rest. Of what is between so much less is asked.
_EDGE, _PART = 0.2, 0.25


def planted(motion: Motion, body: Body, soles: Soles) -> tuple[Motion, Mask, float]:
    """The motion whose resting soles stay.

    Args:
        motion: The motion, T frames, on its ground.
        body: The person's body.
        soles: Its soles.

    Returns:
        The motion; the frames (T, 2) in which the left and the right foot are kept in place; how
        far they were shifted, median [m].
    """
    position, quaternion = body.joint_frames(motion)
    ankles = [JOINT_INDEX[f"{side}_ankle"] for side in SIDES]
    turn = np.array(quaternion[:, ankles])
    shift = np.zeros((len(motion), 2, 3))
    held = np.zeros((len(motion), 2), dtype=bool)
    for k, ankle in enumerate(ankles):
        patches = slice(2 * k, 2 * k + 2)
        centre, rests = soles.centre[:, patches], soles.rests[:, patches]
        held[:, k] = slides(centre, rests, soles.fps)
        if not held[:, k].any():
            continue
        turn[:, k] = steadied(turn[:, k], held[:, k] & rests.all(axis=1), soles.fps)
        turned = rot.multiply(turn[:, k], rot.conjugate(quaternion[:, ankle]))
        centre = _turned_about(centre, position[:, ankle], turned)
        shift[:, k] = foot_shift(centre, rests, held[:, k], soles.fps)
    if not held.any():
        return motion, held, 0.0
    size = float(np.median(np.linalg.norm(shift, axis=-1)[held]))
    return feet_moved(motion, body, shift, turn, held), held, size


def slides(centre: Array, rests: Mask, fps: float) -> Mask:
    """The frames (T,) of those stances in which what rests slides, and by no more than a foot may.

    Args:
        centre: Of heel and toe (T, 2, 3) [m].
        rests: Whether each rests (T, 2).
        fps: Frames per second.
    """
    found = np.zeros(len(centre), dtype=bool)
    stands = np.asarray(rests.any(axis=1))
    for first, end in runs(stands):
        its = _stance(centre[first:end], rests[first:end])
        cut = int(min(_EDGE * fps, _PART * len(its)))
        sure = its[cut : len(its) - cut]
        least = LEAST * len(sure) / len(its)
        found[first:end] = (
            np.abs(sure - sure.mean(axis=0)).max() >= least and np.abs(its).max() <= MOST
        )
    return found


def foot_shift(centre: Array, rests: Mask, held: Mask, fps: float) -> Array:
    """How far a foot is shifted in the level (T, 3) [m] so that what of it rests stays.

    Args:
        centre: Of its heel and toe (T, 2, 3) [m].
        rests: Whether each rests (T, 2).
        held: Frames of the stances in which it is kept in place (T,).
        fps: Frames per second.
    """
    shift, stands = np.zeros((len(centre), 3)), np.asarray(rests.any(axis=1))
    for first, end in runs(held):
        shift[first:end] = _stance(centre[first:end], rests[first:end])
    return over_swings(shift, stands, fps)


def _turned_about(points: Array, pivot: Array, turn: Array) -> Array:
    """Points (T, n, 3) turned (T, 4) about pivots (T, 3)."""
    arm = points - pivot[:, None]
    result: Array = pivot[:, None] + rot.rotate(turn[:, None].repeat(arm.shape[1], axis=1), arm)
    return result


def _stance(centre: Array, rests: Mask) -> Array:
    """The shift (n, 3) within one stance: what rests keeps its place, the mean shift is least."""
    level = centre * [1.0, 1.0, 0.0]
    step = np.zeros((len(centre), 3))
    for t in range(1, len(centre)):
        both = rests[t] & rests[t - 1]
        which = both if both.any() else rests[t]
        step[t] = -(level[t, which] - level[t - 1, which]).mean(axis=0)
    its = np.cumsum(step, axis=0)
    result: Array = its - 0.5 * (its.max(axis=0) + its.min(axis=0))
    return result
