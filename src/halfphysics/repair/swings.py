"""Shifts of a foot between the rests that ask for them: they come and go while it is in the air."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.easing import ease

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: A foot that is lifted is back on its own way within this, and leaves it as long before [s].
SWING = 0.3


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Every run of true frames of a mask (T,): its first frame, and the frame after its last."""
    edges = np.diff(np.concatenate([[0], mask, [0]]).astype(np.int8))
    begins, ends = np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist()
    return list(zip(begins, ends, strict=True))


def over_swings(shift: Array, stands: Mask, fps: float) -> Array:
    """Shifts (T, 3) as they are where a foot stands (T,), and eased in and out between.

    Args:
        shift: Of the foot in the frames in which it stands [m]; in the others it is not looked at.
        stands: Frames in which the foot is on the ground.
        fps: Frames per second.
    """
    blend = max(1, round(SWING * fps))
    result = shift.copy()
    for first, last in runs(~stands):
        t = np.arange(first, last)
        before = shift[first - 1] if first > 0 else np.zeros(3)
        after = shift[last] if last < len(shift) else np.zeros(3)
        length = min(blend, last - first + 1)
        goes = 1.0 - ease((t - first + 1) / length)
        comes = ease((t - last + length) / length)
        # In a swing shorter than both, one goes over into the other.
        over = np.maximum(1.0, goes + comes)
        result[first:last] = (goes / over)[:, None] * before + (comes / over)[:, None] * after
    return result
