"""Joint errors against a reference: MPJPE, relative to the pelvis and in the world."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.base import validation
from halfphysics.base.arrays import as_array
from halfphysics.errors import InputError
from halfphysics.metrics.argument_checks import Array, check_motion


def mpjpe(a: Any, b: Any, body: Any) -> float:
    """Mean error of joint positions relative to the pelvis [mm].

    Both motions are posed on `body`; each frame's pelvis position is subtracted, nothing is
    rotated; the mean is over all frames and 55 joints. Raises `InputError` where lengths or
    frame rates differ.
    """
    p, q = _joints(a, b, body)
    return _mean_error(p - p[:, :1], q - q[:, :1])


def mpjpe_global(a: Any, b: Any, body: Any) -> float:
    """Mean error of joint positions in the world [mm]; otherwise as `mpjpe`."""
    return _mean_error(*_joints(a, b, body))


def _joints(a: Any, b: Any, body: Any) -> tuple[Array, Array]:
    check_motion("a", a)
    check_motion("b", b)
    validation.body(body, "joints")
    if len(a) != len(b):
        raise InputError(
            f"motions of one length are compared, found {len(a)} and {len(b)} frames; "
            "cut the longer one (motion[:n]) or resample one (motion.resample(fps))"
        )
    if abs(a.fps - b.fps) > 1e-6 * abs(b.fps):
        raise InputError(
            f"motions of one frame rate are compared, found {a.fps:g} and {b.fps:g} fps; "
            "resample one: motion.resample(fps)"
        )
    return as_array(body.joints(a)), as_array(body.joints(b))


def _mean_error(p: Array, q: Array) -> float:
    return float(1000.0 * np.linalg.norm(p - q, axis=-1).mean())
