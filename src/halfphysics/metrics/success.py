"""Success: whether a motion has all frames of its reference."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.metrics.argument_checks import check_motion


def success(motion: Any | None, asked: Any) -> bool:
    """Whether a motion is complete: the frames and the rate of the reference, all numbers finite.

    The share of clips for which this holds is the success rate of the paper's Table 1 as we
    define it (the paper leaves room; trackers also count a fall as a failure).

    Args:
        motion: The simulated motion, T frames; None: there is none.
        asked: The reference motion.

    Raises:
        InputError: A value that is no motion.
    """
    check_motion("asked", asked)
    if motion is None:
        return False
    check_motion("motion", motion)
    same = len(motion) == len(asked) and abs(motion.fps - asked.fps) <= 1e-6 * abs(asked.fps)
    arrays = (np.asarray(motion.translation), np.asarray(motion.rotations))
    return same and all(bool(np.isfinite(a).all()) and len(a) == len(asked) for a in arrays)
