"""Jerk and jitter of the joints, and the error of their accelerations against a truth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.metrics.argument_checks import finite_of, joints_of, positions_of

#: Hips, left and right, in SMPL's order: their middle is the pelvis of `acceleration_error`.
HIPS = (1, 2)


def jerk(motion: Any, body: Any) -> float:
    """Mean jerk of the joints in the world [m/s^3].

    The third difference of joint positions, x(t+3) - 3 x(t+2) + 3 x(t+1) - x(t), times fps^3:
    its length, averaged over all frames and 55 joints. The "jitter" of TransPose (Yi et al. 2021,
    section 4.1) over all joints. For noisy motions it grows with the frame rate: compare motions
    of one rate. Exact for joints that move along cubics.

    Args:
        motion: T >= 4 frames.
        body: The body whose joints are measured.

    Raises:
        InputError: Fewer than 4 frames, no motion or no body.
    """
    joints, fps = joints_of(motion, body, least=4, what="jerk")
    third = np.diff(joints, n=3, axis=0) * fps**3
    return float(np.linalg.norm(third, axis=-1).mean())


def jitter(joints: ArrayLike, fps: float) -> float:
    """Jitter [10 m/s^3]: the mean third difference of joint positions times fps^3, over 10.

    Source: as EMDB's table has it, yohanshin/WHAM lib/eval/eval_utils.py, `compute_jitter`, after
    TransPose (Yi et al. 2021). `jerk` is the same in m/s^3 over all 55 joints.

    Args:
        joints: Positions in the world (T, J, 3) [m], T >= 4.
        fps: Frames per second.

    Raises:
        InputError: Fewer frames, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=4)
    third = np.diff(joints, n=3, axis=0) * fps**3
    return float(np.linalg.norm(third, axis=-1).mean() / 10.0)


def acceleration_error(joints: ArrayLike, truth: ArrayLike, fps: float) -> float:
    """Accel [m/s^2]: mean distance between accelerations of joints and the true ones.

    Second differences times fps^2, of positions relative to the middle of the hips.

    Source: HMMR (Kanazawa et al. 2019), as yohanshin/WHAM lib/eval/eval_utils.py,
    `compute_error_accel` after `batch_align_by_pelvis`.

    Args:
        joints: Positions (T, J, 3) [m], T >= 3.
        truth: The true ones (T, J, 3) [m].
        fps: Frames per second.

    Raises:
        InputError: A truth of another shape, fewer frames, or numbers that are not finite.
    """
    joints = positions_of("joints", joints, frames=3, joints=max(HIPS) + 1)
    truth = finite_of("truth", truth, joints.shape, "'joints'")
    own, true = (p - p[:, HIPS].mean(axis=1, keepdims=True) for p in (joints, truth))
    error = np.diff(own, n=2, axis=0) - np.diff(true, n=2, axis=0)
    return float(fps**2 * np.linalg.norm(error, axis=-1).mean())
