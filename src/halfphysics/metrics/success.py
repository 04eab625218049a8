"""Success: whether a motion has all frames of its reference, or stays near it (PHC)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.base.arrays import as_array
from halfphysics.metrics.argument_checks import check_motion, finite_of, positions_of

#: Mean joint error over which a clip is a failure of PHC [m].
FAR = 0.5


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
    arrays = (as_array(motion.translation), as_array(motion.rotations))
    return same and all(bool(np.isfinite(a).all()) and len(a) == len(asked) for a in arrays)


def phc_success(joints: ArrayLike, truth: ArrayLike) -> bool:
    """PHC's success: in no frame is the mean distance of the joints from the truth over 0.5 m.

    Positions are those in the world, nothing is aligned. The share of clips for which this holds is
    the success rate. Joints that are not finite are far from all.

    Source: Perpetual Humanoid Control (Luo et al. 2023), ZhengyiLuo/PHC.

    Args:
        joints: Positions (T, J, 3) [m].
        truth: The true ones (T, J, 3) [m].

    Raises:
        InputError: Positions of another shape, or a truth of one or that is not finite.
    """
    joints = positions_of("joints", joints, frames=1, finite=False)
    truth = finite_of("truth", truth, joints.shape, "'joints'")
    return bool((np.linalg.norm(joints - truth, axis=-1).mean(axis=1) <= FAR).all())
