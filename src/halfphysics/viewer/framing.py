"""A camera that has everything in the part of a window that the panel leaves free."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halfphysics.viewpoint import FOV

Array = NDArray[np.float64]

#: The panel takes this much of the right side of a window that is wide [pixels].
WIDE, PANEL = 700, 335
#: Part of a narrow window's height that is above the panel.
ABOVE = 0.4
# Nearest to a point that the camera comes [m], and how much of the free part is filled.
_NEAR, _FILLED = 0.5, 0.92


def free_part(width: float, height: float) -> tuple[float, float]:
    """Width and height of what the panel leaves free, from the upper left corner [pixels]."""
    if width > WIDE:
        return width - PANEL, height
    return width, ABOVE * height


def framed(
    points: Array, direction: Array, size: tuple[float, float], free: tuple[float, float]
) -> tuple[Array, Array]:
    """Position and look-at point (3,) [m] of the nearest camera that has everything in view.

    Args:
        points: What must be seen (N, 3) [m].
        direction: Unit, from there to the camera.
        size: Of the window [pixels].
        free: Width and height of the part in its upper left corner to show them in [pixels].
    """
    ahead = -np.asarray(direction, dtype=np.float64)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    depth = points @ ahead
    half = math.tan(math.radians(0.5 * FOV))
    across = half * size[0] / size[1]
    # Slopes of the rays through the edges of the free part, a little inside them.
    middle = across * (free[0] / size[0] - 1.0), half * (1.0 - free[1] / size[1])
    reach = _FILLED * across * free[0] / size[0], _FILLED * half * free[1] / size[1]
    back, at = np.max(-depth) + _NEAR, []
    for axis, centre, part in zip((right, up), middle, reach, strict=True):
        along = points @ axis
        # Camera at c, `back` behind the origin: (along - c) / (depth + back) within the edges.
        low = np.max(along - (centre + part) * depth)
        high = np.min(along - (centre - part) * depth)
        back = max(back, (low - high) / (2.0 * part))
        at.append((axis, centre, part, low, high))
    position = -back * ahead
    for axis, centre, part, low, high in at:
        first, last = low - (centre + part) * back, high - (centre - part) * back
        position = position + 0.5 * (first + last) * axis
    return position, position + (back + float(depth.mean())) * ahead
