"""Sliding of feet by the rules of other projects: GMD's ratio, and FS of EgoEgo, OMOMO and CHOIS.

Both look at joints (T, J, 3) [m], z up, in SMPL's order (J >= 22): 7 and 8 are the ankles, 10 and
11 the toes, as in SMPL-H and SMPL-X. The ground is level.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.metrics.argument_checks import Array, positions_of

#: Ankles and toes, left and right, in SMPL's order.
ANKLES, TOES = (7, 8), (10, 11)
#: Fewest joints that have them all.
FEWEST = max(TOES) + 1
#: GMD: toes under this [m] in both frames of a step, faster than this [m/s], also on average over
#: so many steps.
GMD_HEIGHT, GMD_SPEED, GMD_WINDOW = 0.05, 0.5, 5
#: FS: heights under which ankles and toes are weighted [m].
ANKLE_HEIGHT, TOE_HEIGHT = 0.08, 0.04


def gmd_skating_ratio(
    joints: ArrayLike,
    fps: float,
    *,
    ground: float = 0.0,
    height: float = GMD_HEIGHT,
    speed: float = GMD_SPEED,
) -> float:
    """Foot skating ratio: share of the T - 1 steps in which a toe skates, 0 to 1.

    A toe skates in a step where it is under `height` in both frames, its horizontal speed is over
    `speed`, and so is the mean of this speed over 5 steps, the step in the middle (beyond the ends
    of the clip it counts as 0). Either foot suffices.

    Source: Guided Motion Diffusion (Karunratanakul et al. 2023), korrawe/guided-motion-diffusion
    data_loaders/humanml/utils/metrics.py, `calculate_skating_ratio`, at 20 frames per second. At
    another rate the speed stays in m/s and the window 5 steps.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        fps: Frames per second.
        ground: Height of the ground [m].
        height: Height [m] under which a toe is on the ground.
        speed: Horizontal speed [m/s] over which it skates.

    Raises:
        InputError: Fewer frames or joints, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    toes = joints[:, TOES]
    low = toes[..., 2] - ground < height
    speeds = _steps(toes) * fps
    skates = low[:-1] & low[1:] & (speeds > speed) & (_window_mean(speeds, GMD_WINDOW) > speed)
    return float(skates.any(axis=1).mean())


def foot_sliding_mm(joints: ArrayLike, *, ground: float = 0.0) -> float:
    """FS, foot sliding [mm]: horizontal steps of ankles and toes, weighted by how low they are.

    Of each ankle (H = 8 cm) and toe (H = 4 cm) the sum over the steps that it begins at a height
    h < H of its horizontal displacement times 2 - 2^(h / H), over the number of frames T; the mean
    of the four.

    Source: EgoEgo (Li et al. 2023), OMOMO (Li et al. 2023) and CHOIS (Li et al. 2024),
    lijiaman/chois_release evaluation_metrics.py, `compute_foot_sliding_for_smpl`.

    Args:
        joints: Positions (T, J, 3) [m], T >= 2.
        ground: Height of the ground [m].

    Raises:
        InputError: Fewer frames or joints, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=2, joints=FEWEST)
    total = 0.0
    for pair, limit in ((ANKLES, ANKLE_HEIGHT), (TOES, TOE_HEIGHT)):
        height = joints[:-1, pair, 2] - ground
        weight = np.where(height < limit, 2.0 - 2.0 ** (height / limit), 0.0)
        total += float((_steps(joints[:, pair]) * weight).sum())
    return 1000.0 * total / (4 * len(joints))


def _steps(points: Array) -> Array:
    """Horizontal displacements (T - 1, n) of points (T, n, 3)."""
    steps: Array = np.linalg.norm(np.diff(points[..., :2], axis=0), axis=-1)
    return steps


def _window_mean(values: Array, window: int) -> Array:
    """Mean of values (T, n) over `window` rows about each, rows beyond the ends being 0."""
    half = window // 2
    padded: NDArray[np.float64] = np.zeros((len(values) + 2 * half, values.shape[1]))
    padded[half : half + len(values)] = values
    windows = np.lib.stride_tricks.sliding_window_view(padded, window, axis=0)
    mean: Array = windows.mean(axis=-1)
    return mean
