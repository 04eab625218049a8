"""Jerk: the rate of change of the joints' accelerations."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.metrics.argument_checks import joints_of


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
