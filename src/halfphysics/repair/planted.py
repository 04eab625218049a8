"""Planted feet: a sole that rests stays where it is, by the leg.

While a heel or a toe rests it keeps one place, on the ground; where the load goes from heel to toe,
the toe keeps the place at which it was when it came to rest. Each foot is shifted by what that
takes, and back onto its own way while it swings; the leg follows by hip, knee and ankle. Where both
heel and toe rest, the foot keeps its rotation as well, as far as noise turns it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.adaptation import arm_pose
from halfphysics.adaptation.feet import Foot, in_reach
from halfphysics.base import rotations as rot
from halfphysics.motion.easing import ease

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.repair.soles import Soles

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A foot that is lifted is back on its own way within this, and leaves it as long before [s].
_SWING = 0.3
#: A foot is shifted by no more than this [m]: beyond, its rest was none.
MOST = 0.15
#: Less than this is how soles roll and give, not damage: mean over a rest [m].
LEAST = 0.008
#: How willingly hip, knee and ankle turn (axis-angle components of each); the knee is a hinge.
_WILLING = np.array([1.0, 0.3, 1.0, 1.0, 0.02, 0.02, 0.6, 0.6, 0.6])


def planted(motion: Motion, body: Body, soles: Soles) -> tuple[Motion, float]:
    """The motion whose resting soles stay; and how far they were shifted, median [m].

    Args:
        motion: The motion, T frames, on its ground.
        body: The person's body.
        soles: Its soles.
    """
    position, quaternion = body.joint_frames(motion)
    rotations = np.array(motion.rotations)
    sizes = []
    for k, side in enumerate(("left", "right")):
        foot = Foot.of(body, side)
        rests = soles.rests[:, 2 * k : 2 * k + 2]
        if foot is None or not rests.any():
            continue
        shift = foot_shift(soles.centre[:, 2 * k : 2 * k + 2], rests, soles.fps)
        moved = np.linalg.norm(shift, axis=1)
        if not moved.any():
            continue
        sizes.append(moved[rests.any(axis=1)])
        frames = np.flatnonzero(moved > 0.0)
        ankle = foot.limb[2]
        goal = in_reach(body, foot, position, position[:, ankle] + shift)
        rotations[np.ix_(frames, np.array(foot.limb))] = arm_pose.moved(
            motion, body, foot, frames, goal[frames], rot.to_matrix(quaternion[frames, ankle]),
            _WILLING,
        )  # fmt: skip
    size = float(np.median(np.concatenate(sizes))) if sizes else 0.0
    return (motion.with_frames(motion.translation, rotations) if sizes else motion), size


def foot_shift(centre: Array, rests: Mask, fps: float) -> Array:
    """How far a foot is shifted in the level (T, 3) [m] so that what of it rests stays.

    Args:
        centre: Of its heel and toe (T, 2, 3) [m].
        rests: Whether each rests (T, 2).
        fps: Frames per second.
    """
    shift = np.zeros((len(centre), 3))
    stands = rests.any(axis=1)
    edges = np.diff(np.concatenate([[0], stands, [0]]).astype(np.int8))
    begins, ends = np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist()
    stances = list(zip(begins, ends, strict=True))
    for first, end in stances:
        its = _stance(centre[first:end], rests[first:end])
        if np.abs(its - its.mean(axis=0)).max() < LEAST or np.abs(its).max() > MOST:
            continue
        shift[first:end] = its
    return _swings(shift, stances, fps)


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


def _swings(shift: Array, stances: list[tuple[int, int]], fps: float) -> Array:
    """Shifts (T, 3) that come and go while the foot is in the air."""
    blend = max(1, round(_SWING * fps))
    result = shift.copy()
    lifted = [0, *(end for _, end in stances)]
    lands = [*(begin for begin, _ in stances), len(shift)]
    for first, last in zip(lifted, lands, strict=True):
        if last <= first:
            continue
        t = np.arange(first, last)
        before = shift[first - 1] if first > 0 else np.zeros(3)
        after = shift[last] if last < len(shift) else np.zeros(3)
        length = min(blend, last - first + 1)
        goes = 1.0 - ease((t - first + 1) / length)
        comes = ease((t - last + length) / length)
        # In a swing shorter than both, one goes over into the other.
        whole = goes + comes
        over = np.maximum(1.0, whole)
        result[first:last] = (goes / over)[:, None] * before + (comes / over)[:, None] * after
    return result
