"""Checks of the arguments of measures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base import validation
from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

Array = NDArray[np.float64]


def check_motion(name: str, motion: Any, *, pose: bool = False) -> None:
    """Refuse a value that is no motion; `pose`: a single pose is accepted too.

    Raises:
        InputError: Something else.
    """
    wanted = ("rotations", "translation") if pose else ("rotations", "translation", "fps")
    if isinstance(motion, type) or not all(hasattr(motion, field) for field in wanted):
        kind = "halfphysics.Motion or Pose" if pose else "halfphysics.Motion"
        raise InputError(f"{name}: expected a {kind}, found {shown(motion)}")


def check_result(result: Any) -> None:
    """Refuse a value that is no `Result`.

    Raises:
        InputError: Something else.
    """
    from halfphysics.results.result import Result

    if not isinstance(result, Result):
        raise InputError(
            f"result: expected a halfphysics.Result, as `simulate` gives back, found "
            f"{shown(result)}"
        )


def joints_of(motion: Any, body: Any, *, least: int, what: str) -> tuple[Array, float]:
    """Joints (T, 55, 3) [m] of a motion of at least a number of frames, and its frame rate.

    Raises:
        InputError: No motion, no body, or too few frames for `what`.
    """
    check_motion("motion", motion)
    validation.body(body, "joints")
    if len(motion) < least:
        raise InputError(f"{what} takes at least {least} frames, found {len(motion)}")
    return as_array(body.joints(motion)), validation.frame_rate(motion.fps)


def numbers_of(name: str, value: ArrayLike) -> Array:
    """`value` as an array of numbers: an array, a list, a tensor.

    Raises:
        InputError: Something else.
    """
    try:
        return np.asarray(array_of(value), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: not an array of numbers ({error})") from None


def flags_of(name: str, value: ArrayLike) -> NDArray[np.bool_]:
    """`value` as an array of true and false. Raises `InputError` as `numbers_of`."""
    flags: NDArray[np.bool_] = numbers_of(name, value) != 0.0
    return flags
