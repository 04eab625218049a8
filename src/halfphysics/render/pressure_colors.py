"""Colours of pressure, for maps, for skins and for the browser."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.render.look import Color

#: From no pressure to the end of a scale, evenly spaced; sRGB, 0 to 1. Each is darker than the one
#: before, so that the map reads in grey, too.
RAMP: tuple[Color, ...] = (
    (0.945, 0.950, 0.960),
    (0.992, 0.890, 0.560),
    (0.988, 0.690, 0.290),
    (0.930, 0.430, 0.210),
    (0.790, 0.190, 0.270),
    (0.530, 0.080, 0.370),
    (0.230, 0.030, 0.300),
)


def shades(share: ArrayLike) -> NDArray[np.float64]:
    """Colours (..., 3), sRGB 0 to 1, at shares (...) of a scale; outside 0 to 1: its ends."""
    at = np.clip(np.asarray(share, dtype=np.float64), 0.0, 1.0) * (len(RAMP) - 1)
    columns = np.array(RAMP).T
    return np.stack([np.interp(at, np.arange(len(RAMP)), column) for column in columns], axis=-1)


def scale_end(most: float) -> float:
    """The end of a scale that holds values up to `most`: 1, 1.5, 2, 3, 4, 5, 6 or 8 tens."""
    if not most > 0.0:
        return 1.0
    ten = 10.0 ** np.floor(np.log10(most))
    for step in (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0):
        if step * ten >= most * (1.0 - 1e-9):
            return float(step * ten)
    return float(10.0 * ten)
