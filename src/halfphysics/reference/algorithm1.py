"""What bounds Algorithm 1 of the paper: how fast joints return, and how limp joints are damped."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics._native import tuning
from halfphysics.settings import Settings

Array = NDArray[np.float64]


def returning(settings: Settings, turning: Array, asked: Array) -> Array:
    """Angular velocities (n, 3) that lead to the target, no faster back to those of the motion,
    `asked` (n, 3), than they may."""
    if settings.drive.torque_frequency > 0.0:
        return turning
    motion = np.linalg.norm(asked, axis=1, keepdims=True)
    most = settings.recovery_rate + tuning.return_per_motion * motion
    size = np.linalg.norm(turning - asked, axis=1, keepdims=True)
    return np.asarray(asked + np.minimum(1.0, most / np.maximum(size, 1e-300)) * (turning - asked))


def resistance(settings: Settings, firmness: Array, h: float) -> Array:
    """What joints resist with, in their own inertia (55,): lambda, `firmness` (55,); with
    Algorithm 1 at least what damps a limp joint in a substep of length h."""
    drive = settings.drive
    own = drive.internal_forces or drive.joint_damping > 0.0 or drive.torque_frequency > 0.0
    if settings.drive_time is not None or own:
        return firmness
    return np.maximum(firmness, h / tuning.limp_time)
