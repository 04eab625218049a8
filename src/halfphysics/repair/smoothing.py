"""Jitter of estimators taken off, only where it is asked for: a filter without a phase."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import number
from halfphysics.metrics.airborne import smoothed

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


def low_passed(motion: Motion, cutoff: float) -> Motion:
    """The motion with translation and rotations low-passed along time, nothing delayed.

    Butterworth of second order, forwards and backwards. Rotations are filtered as quaternions of
    one sign and put back to length 1: for turns of under half a revolution within a period of the
    cutoff that is the mean rotation to second order.

    Args:
        motion: T frames.
        cutoff: Frequency of which half the power of one pass is left [Hz]; from half the frame
            rate on the motion itself is returned.

    Raises:
        InputError: `cutoff` is not positive.
    """
    cutoff = number(cutoff, "smooth", above=0.0, unit="Hz")
    if len(motion) < 2 or cutoff >= 0.5 * motion.fps:
        return motion
    quaternions = rot.continuous(rot.exp(motion.rotations))
    filtered = rot.normalize(smoothed(quaternions, motion.fps, cutoff))
    still = np.ptp(motion.rotations, axis=0).max(axis=-1) == 0.0
    turns = rot.log(filtered)
    turns[:, still] = motion.rotations[:, still]
    return motion.with_frames(smoothed(motion.translation, motion.fps, cutoff), turns)
