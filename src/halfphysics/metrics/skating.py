"""Foot skate: sliding of feet that are on the ground."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from halfphysics.base.validation import number
from halfphysics.metrics.argument_checks import joints_of
from halfphysics.metrics.foot_sliding import gmd_skating_ratio
from halfphysics.motion.skeleton import JOINT_INDEX

#: The balls of the feet.
FEET = tuple(JOINT_INDEX[name] for name in ("left_foot", "right_foot"))


@dataclass(frozen=True, kw_only=True)
class SkateReport:
    """Sliding of feet on the ground. A step is the interval from one frame to the next.

    Attributes:
        share_percent: Share of all steps in which at least one foot that is on the ground in both
            frames moves faster than the limit, also on average over 5 steps about it [%]: 100 times
            `halfphysics.metrics.foot_sliding.gmd_skating_ratio`.
        mean_mm: Mean horizontal displacement of feet in the steps in which they are on the
            ground in both frames [mm/frame]; 0 if there are none.
        mean_speed: The same as a speed [m/s].
        steps: Number of (step, foot) pairs over which `mean_mm` is averaged.
    """

    share_percent: float
    mean_mm: float
    mean_speed: float
    steps: int


def foot_skate(
    motion: Any, body: Any, *, ground: float = 0.0, height: float = 0.05, speed: float = 0.5
) -> SkateReport:
    """Sliding of the feet on level ground.

    A foot is its ball, the joint "left_foot" or "right_foot"; it is on the ground in a step where
    it is lower than `height` in both frames. `share_percent` is the foot skating ratio of Guided
    Motion Diffusion (Karunratanakul et al. 2023) as its code has it, with the mean over 5 steps;
    `mean_mm` is the "skate" of PhysDiff (Yuan et al. 2023). A foot that is being lifted or set down
    moves within `height` too, so that a real walk is not exactly 0.

    Args:
        motion: T >= 2 frames.
        body: The body whose joints are measured.
        ground: Height of the ground [m].
        height: Height of the ball of a foot under which the foot is on the ground [m].
        speed: Horizontal speed over which it skates [m/s].

    Raises:
        InputError: An impossible number, fewer than 2 frames, no motion or no body.
    """
    ground = number(ground, "ground", unit="m")
    height = number(height, "height", above=0.0, unit="m")
    speed = number(speed, "speed", least=0.0, unit="m/s")
    joints, fps = joints_of(motion, body, least=2, what="foot skate")
    feet = joints[:, FEET]
    low = feet[..., 2] - ground < height
    down = low[1:] & low[:-1]
    way = np.linalg.norm(np.diff(feet[..., :2], axis=0), axis=-1)
    mean = float(way[down].mean()) if down.any() else 0.0
    return SkateReport(
        share_percent=100.0
        * gmd_skating_ratio(joints, fps, ground=ground, height=height, speed=speed),
        mean_mm=1000.0 * mean,
        mean_speed=mean * fps,
        steps=int(down.sum()),
    )
