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


def beside(name: str, value: ArrayLike, truth: ArrayLike) -> tuple[Array, Array]:
    """Two arrays of finite numbers of one shape: `value`, and its `truth`.

    Raises:
        InputError: Something else.
    """
    own = finite_of(name, value)
    return own, finite_of("truth", truth, own.shape, f"'{name}'")


def finite_of(
    name: str, value: ArrayLike, shape: tuple[int, ...] | None = None, of: str = ""
) -> Array:
    """`value` as an array of finite numbers, of a shape where one is given, as `of` has it.

    Raises:
        InputError: Something else.
    """
    array = numbers_of(name, value)
    if shape is not None and array.shape != shape:
        raise InputError(f"{name}: found shape {array.shape}, expected {shape} as of {of}")
    if not np.isfinite(array).all():
        count = int((~np.isfinite(array)).sum())
        raise InputError(f"{name}: found {count} numbers that are not finite, expected none")
    return array


def positions_of(
    name: str, value: ArrayLike, *, frames: int, joints: int = 1, finite: bool = True
) -> Array:
    """`value` as positions (T, J, 3) of at least so many frames and joints.

    Raises:
        InputError: Something else, or with `finite` a number that is not finite.
    """
    array = finite_of(name, value) if finite else numbers_of(name, value)
    if array.ndim != 3 or array.shape[2] != 3:
        raise InputError(f"{name}: found shape {array.shape}, expected (T, J, 3)")
    if len(array) < frames or array.shape[1] < joints:
        raise InputError(
            f"{name}: found {len(array)} frames of {array.shape[1]} joints, expected at least "
            f"{frames} of {joints}"
        )
    return array
