"""What frames of a motion are counted by: whole numbers, and slices of them."""

from __future__ import annotations

import operator

from halfphysics.base.validation import shown
from halfphysics.errors import InputError

_TIME = "time t [s] is frame t * fps"


def check_index(index: object) -> None:
    """Refuse what is no number of a frame.

    Raises:
        InputError: It is no whole number.
    """
    if not _is_index(index):
        raise InputError(
            f"motion[...]: found {shown(index)}, expected the number of a frame or a slice of "
            f"frames; {_TIME}"
        )


def check_slice(index: slice) -> None:
    """Refuse a slice of anything but whole frames.

    Raises:
        InputError: A part of it is no whole number, or its step is 0.
    """
    parts = (index.start, index.stop, index.step)
    if not all(part is None or _is_index(part) for part in parts) or index.step == 0:
        raise InputError(
            f"motion[...]: found {shown(index)}, expected whole frames and a step that is not 0; "
            f"{_TIME}"
        )


def _is_index(value: object) -> bool:
    if isinstance(value, bool):  # an index of Python's lists, and a mask of numpy's arrays
        return False
    try:
        operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return False
    return True
