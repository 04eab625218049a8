"""Checks of single values a caller gave: numbers, vectors, unit quaternions.

Each raises `InputError` that names the value, its purpose and the expected values.
"""

from __future__ import annotations

import errno
import math
import numbers
import os
from collections.abc import Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array, scalar_of
from halfphysics.errors import FileError, InputError

T = TypeVar("T")

#: Errors of the system for a path at which there is no file.
_NOT_THERE = (errno.ENOENT, errno.ENOTDIR, errno.ELOOP)


def number(
    value: object,
    what: str,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
    unit: str = "",
) -> float:
    """`value` as a finite float within (above, ...) or [least, most]."""
    wanted = "a number"
    if above is not None:
        wanted += f" above {above:g}"
    if least is not None and most is not None:
        wanted += f" from {least:g} to {most:g}"
    elif least is not None:
        wanted += f" of at least {least:g}"
    if unit:
        wanted += f" [{unit}]"
    result = real(value)
    if result is None:
        raise InputError(f"{what}: expected {wanted}, found {shown(value)}")
    if not within(result, above=above, least=least, most=most):
        raise InputError(f"{what}: expected {wanted}, found {result:g}")
    return result


def real(value: object, *, plain: bool = False) -> float | None:
    """`value` as a float: inf if it is too large for one, None if it is not a real number.

    A bool is not a number. With `plain` only Python's own int and float are, which every file
    format can hold; otherwise also numpy's numbers, arrays and tensors of no dimension, and
    decimal numbers.
    """
    if not plain:
        value = scalar_of(value)
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real | Decimal):
        return None
    if plain and not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:  # a whole number of 309 digits
        return -math.inf if value < 0 else math.inf
    except ValueError:  # a decimal that signals that it is none
        return None


def within(
    value: float,
    *,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> bool:
    """Whether `value` is finite and within (above, ...) or [least, most]."""
    return (
        math.isfinite(value)
        and (above is None or value > above)
        and (least is None or value >= least)
        and (most is None or value <= most)
    )


def is_whole(value: object, *, least: int | None = None, plain: bool = True) -> bool:
    """Whether `value` is an int (with plain=False also a numpy integer) of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int if plain else int | np.integer):
        return False
    return least is None or bool(value >= least)


def vector(value: object, what: str, size: int = 3, *, unit: str = "") -> NDArray[np.float64]:
    """`value` as a read-only float64 array (size,) of finite numbers."""
    wanted = f"{size} finite numbers" + (f" [{unit}]" if unit else "")
    try:
        raw = as_array(value)
        ok = raw.dtype.kind in "fiu" and raw.shape == (size,)
        array = np.array(raw, dtype=np.float64) if ok else None
    except (TypeError, ValueError):
        array = None
    if array is None or not np.isfinite(array).all():
        raise InputError(f"{what}: expected {wanted}, found {shown(value)}")
    array.setflags(write=False)
    return array


def quaternion(value: object, what: str) -> NDArray[np.float64]:
    """`value` (w, x, y, z) scaled to unit length, a read-only array (4,)."""
    raw = vector(value, what, 4)
    largest = np.abs(raw).max()
    scaled = raw / largest if largest > 0.0 else raw
    length = np.linalg.norm(scaled)
    if not length > 0.5:  # the largest component is 1 unless all are zero
        raise InputError(
            f"{what}: a quaternion of zero length is no rotation; "
            "expected w, x, y, z (no rotation: 1, 0, 0, 0)"
        )
    # An exact unit quaternion stays as it is, so that saving and loading changes nothing.
    exact = largest <= 1.0 and abs(float(raw @ raw) - 1.0) < 1e-15
    unit = raw if exact else scaled / length
    unit.setflags(write=False)
    return unit


def frame_rate(value: object, example: str = "30.0", *, most: float | None = None) -> float:
    """`value` as frames per second, `most` at most."""
    fps = real(value)
    if fps is None or not within(fps, above=0.0):
        raise InputError(
            f"fps: found {shown(value)}, expected a positive number, such as {example}"
        )
    if most is not None and fps > most:
        raise InputError(f"fps: found {fps:g}, expected at most {most:g} frames per second")
    return fps


def file_path(value: object) -> Path:
    """`value` as a path that can be accessed; the file itself may be missing.

    Raises:
        InputError: It is no path.
        FileError: It or a folder above it may not be read, or the name is too long.
    """
    try:
        text = os.fspath(value)  # type: ignore[call-overload]
    except TypeError:
        text = None
    if not isinstance(text, str) or "\0" in text:
        raise InputError(f"path: expected the path of a file, text or a Path, found {shown(value)}")
    path = Path(text)
    try:
        path.stat()
    except OSError as error:
        if error.errno not in _NOT_THERE:
            raise FileError(f"{path}: cannot be reached: {error.strerror}") from None
    if path.is_dir() and not os.access(path, os.R_OK | os.X_OK):
        raise FileError(f"{path}: cannot read this folder: Permission denied")
    return path


def file_bytes(path: Path) -> bytes:
    """The content of a file that is there; raises `FileError` where the system does not give it."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None


def several(value: T | Sequence[T]) -> list[T]:
    """One value, or a list or tuple of them, as a list."""
    return list(value) if isinstance(value, list | tuple) else [cast(T, value)]


def body(value: Any, method: str) -> Any:
    """`value` if it has a body's `method`; a class or a function that makes bodies is none."""
    if isinstance(value, type) or not callable(getattr(value, method, None)):
        raise InputError(
            f"body: expected a halfphysics.Body, such as Body.default(), found {shown(value)}"
        )
    return value


def shown(value: object) -> str:
    """`value` for a message, cut to a readable length."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
