"""The rotation of a foot that rests flat, without the noise that turns it.

While heel and toe rest, a foot turns by noise, or rolls slowly. Its rotation is replaced by the
quadratic in time that fits best around each frame (Savitzky and Golay 1964): a roll stays as it is,
noise falls to a half or less, and nothing jumps where the rest begins or ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.repair.swings import runs

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: The quadratic is fitted over this [s], or over the whole rest where that is shorter.
WINDOW = 0.5
#: A foot is turned by no more than this [rad]: what turns more is no noise.
MOST = np.deg2rad(4.0)
#: Over fewer frames than this a quadratic takes off nothing.
_FRAMES = 5


def steadied(quaternion: Array, flat: Mask, fps: float) -> Array:
    """Rotations (T, 4) of a foot, steady where it rests flat (T,), elsewhere as they were."""
    from scipy.signal import savgol_filter

    result = quaternion.copy()
    for first, end in runs(flat):
        width = min(round(WINDOW * fps), end - first)
        width -= 1 - width % 2
        if width < _FRAMES:
            continue
        its = rot.continuous(quaternion[first:end])
        smooth = rot.normalize(savgol_filter(its, width, 2, axis=0, mode="interp"))
        turn = rot.log(rot.multiply(smooth, rot.conjugate(its)))
        size = np.linalg.norm(turn, axis=1, keepdims=True)
        turn *= np.minimum(1.0, MOST / np.maximum(size, 1e-12))
        result[first:end] = rot.multiply(rot.exp(turn), its)
    return result
