"""Joint positions to write: what the files of generators of motion hold of a `Motion`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.base.axes import axes_of
from halfphysics.base.stored_objects import write_object_array
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.formats.motion_builder import lost_joints, lost_rate
from halfphysics.formats.positions.layouts import BODY, FPS
from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


def places_of(motion: Motion, body: Body | None, format: str) -> Array:
    """Positions (T, 22, 3) of SMPL's first joints [m], y up; of a file of this format, in its axes.

    Raises:
        InputError: No body.
    """
    if body is None:
        raise InputError(
            f"format: '{format}' holds the joints of the person. Say whose motion it is with body="
        )
    own = motion.origin is not None and motion.origin.format == format
    axes = motion.axes if own else axes_of("y")
    return np.asarray(body.joints(motion)[:, list(BODY)] @ axes)


def write_array(path: Path, content: Any) -> None:
    """Write an array, or a dict in one of objects, as `numpy.save` does.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    with atomic_write(path) as handle:
        if isinstance(content, dict):
            write_object_array(handle, content)
        else:
            np.lib.format.write_array(handle, np.asanyarray(content), allow_pickle=False)


def lost_without_twist(motion: Motion) -> tuple[str, ...]:
    """`Format.loses` of files with the positions of 22 joints."""
    shape = motion.betas is not None and motion.betas.any()
    return (
        "turns of bones about themselves",
        *lost_joints(motion, BODY),
        *(("the shape (betas), but for the joints of it",) if shape else ()),
        *lost_rate(motion, FPS),
    )
