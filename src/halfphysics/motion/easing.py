"""Easing: from one value to another without a jerk."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def ease(x: ArrayLike) -> Array:
    """Ease from 0 at 0 to 1 at 1, constant beyond, by the polynomial of least jerk.

    10 x^3 - 15 x^4 + 6 x^5 (Flash and Hogan 1985): speed and acceleration vanish at both ends.
    """
    x = np.clip(np.asarray(x, dtype=np.float64), 0.0, 1.0)
    result: Array = x * x * x * (10.0 + x * (6.0 * x - 15.0))
    return result
