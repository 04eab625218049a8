"""Bending legs: the feet stay in place while the pelvis moves down and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import N_JOINTS
from halfphysics.scenarios.acting.legs import WORLD_FROM_REST, Leg, about, leg_of, planted, solve

if TYPE_CHECKING:
    from halfphysics.body.body import Body

Array = NDArray[np.float64]

#: Height of the feet above the floor [m]: a little more than the clearance.
FEET = 0.002
#: Loss of height by bent knees when standing [m]: a straight leg defines no plane.
_BENT = 0.005


def eased(times: Array, start: float, seconds: float) -> Array:
    """A smooth step from 0 to 1 from `start` [s] within `seconds`; has the shape of `times`."""
    x = np.clip((times - start) / seconds, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def standing_height(body: Body) -> float:
    """Height of the pelvis joint above the floor with almost straight legs [m]."""
    rest = [leg.height - (leg.hip + leg.thigh + leg.shank)[1] for leg in _legs(body)]
    result: float = min(rest) + FEET - _BENT
    return result


def squat(body: Body, back: Array, down: Array, lean: Array, roll: Array, fps: float) -> Motion:
    """A person at the origin facing +x, arms in T-pose, feet flat on z = 0.

    Args:
        body: The person's body.
        back: Distance of the pelvis behind its standing position (T,) [m].
        down: Distance of the pelvis below its standing height (T,) [m].
        lean, roll: Rotation of the pelvis, forward and then to the right (T,) [rad].
        fps: Frames per second.
    """
    frames = len(back)
    height = standing_height(body)
    pelvis = np.stack([-back, np.zeros(frames), height - down], axis=1)
    root = about(0, roll) @ about(1, lean) @ WORLD_FROM_REST
    rotations = np.zeros((frames, N_JOINTS, 3))
    rotations[:, 0] = rot.matrix_to_rotvec(root)
    flat = np.zeros(frames)
    foot = np.broadcast_to(WORLD_FROM_REST, (frames, 3, 3))
    for leg in _legs(body):
        under = WORLD_FROM_REST @ (leg.hip + leg.thigh + leg.shank)
        ankle = planted(leg, under[:2], 0.0, flat) + np.array([0.0, 0.0, FEET])
        hip = pelvis + root @ leg.hip
        for joint, turn in solve(leg, root, hip, ankle, foot, flat).items():
            rotations[:, joint] = turn
    return Motion(pelvis - np.asarray(body.rest_joints)[0], rotations, fps)


def _legs(body: Body) -> tuple[Leg, ...]:
    return tuple(leg_of(body, side) for side in ("left", "right"))
