"""A camera that frames a scene in the part of a window that the panel leaves free."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Camera
from halfphysics.render.viewpoint import FOV

Array = NDArray[np.float64]

#: Assumed window [pixels] until a browser reports its own.
WINDOW = (1280, 720)
# A window wider than `_WIDE` has the panel, `_PANEL` wide, on its right side [pixels].
_WIDE, _PANEL = 580, 335
# In a narrower window, and in one this many times higher than wide (a phone with small pixels),
# the panel is a sheet below this fraction of the height, folded at first.
_TALL, _ABOVE = 1.5, 0.9
# Least distance of the camera to a point [m], and the filled fraction of the free part.
_NEAR, _FILLED = 0.5, 0.92
# The fraction of the window's height that people fill at first, and of the free part at most.
_HALF, _MOST = 0.5, 0.85


def free_part(width: float, height: float) -> tuple[float, float]:
    """Width and height of the free part, from the upper left corner [pixels]."""
    if width > _WIDE and height < _TALL * width:
        return width - _PANEL, height
    return width, _ABOVE * height


def framed(
    points: Array,
    direction: Array,
    window: tuple[float, float],
    *,
    distance: float = 0.0,
    filled: tuple[float, float] = (_FILLED, _FILLED),
    panel: bool = True,
) -> Camera:
    """The nearest camera that has all points in the free part of a window.

    Args:
        points: Points that must be in view (N, 3) [m].
        direction: From the points to the camera, not straight up (3,).
        window: Width and height [pixels].
        distance: Least distance from the middle of the points [m].
        filled: Most of the free part's width and height that the points take.
        panel: Whether the window has a panel; if not, all of it is free.
    """
    ahead = -np.asarray(direction, dtype=np.float64)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    depth = points @ ahead
    free = free_part(*window) if panel else window
    half = math.tan(math.radians(0.5 * FOV))
    across = half * window[0] / window[1]
    # Slopes of the rays through the edges of the free part, a little inside them.
    middle = across * (free[0] / window[0] - 1.0), half * (1.0 - free[1] / window[1])
    reach = filled[0] * across * free[0] / window[0], filled[1] * half * free[1] / window[1]
    back, at = max(float(np.max(-depth)) + _NEAR, distance - float(depth.mean())), []
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
    target = position + (back + float(depth.mean())) * ahead
    return Camera(position=position, target=target, fov=FOV)


def on_people(
    points: Array, direction: Array, window: tuple[float, float], *, panel: bool = True
) -> Camera:
    """The camera of the first picture: people fill half of the window's height.

    Less where that is needed to have all of them in the free part.

    Args:
        points, direction, window, panel: As for `framed`.
    """
    free = free_part(*window)[1] if panel else window[1]
    filled = _FILLED, min(_HALF * window[1] / free, _MOST)
    return framed(points, direction, window, filled=filled, panel=panel)
