"""Up axes: from the axes of a file to the z-up world and back."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

Array = NDArray[np.float64]

#: World from file axes, by the axis that is up in the file.
AXES: Mapping[str, Array] = MappingProxyType(
    {
        "z": np.eye(3),
        "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
        # Cameras: x right, y down, z ahead.
        "-y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
        "x": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
        "-x": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
        "-z": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]),
    }
)


def axes_of(up: str) -> Array:
    """World from file axes (3, 3) for a file whose `up` axis is one of `AXES` ("-y": y is down)."""
    if not isinstance(up, str) or up not in AXES:
        raise InputError(f"up: found {shown(up)}, expected one of {', '.join(AXES)}")
    return AXES[up]


def name_along(axes: Array, direction: Array) -> str:
    """The axis of a file, such as "-y", that points in a direction (3,) of the world.

    Args:
        axes: World from file axes (3, 3).
        direction: Along an axis of the file; else the nearest is named.
    """
    there = axes.T @ direction
    axis = int(np.argmax(np.abs(there)))
    return ("-" if there[axis] < 0.0 else "") + "xyz"[axis]


def turned(translation: Array, rotations: Array, turn: Array) -> tuple[Array, Array]:
    """Translation (T, 3) and rotations (T, 55, 3) with the root turned by `turn` (3, 3)."""
    rotations = np.array(rotations)
    rotations[:, 0] = rot.log(rot.multiply(rot.from_matrix(turn), rot.exp(rotations[:, 0])))
    return translation @ turn.T, rotations
