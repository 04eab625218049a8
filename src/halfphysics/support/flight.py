"""Flights: frames in which a person falls freely, in a jump or from something."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Largest share of the weight that is missing on average in a flight.
SUPPLIED = 0.3


def flights(centre: Array, fps: float, gravity: Array, carried: Mask) -> Mask:
    """Frames (T,) of flights.

    A flight is a run of frames in which nothing is near enough to carry, over the whole of which
    the velocity of the centre of mass changes as gravity has it, to `SUPPLIED`: whoever floats is
    not airborne. Velocities are those from frame to frame, unfiltered: a filter would spread a
    landing into the flight.

    Args:
        centre: Centre of mass (T, 3) [m].
        fps: Frames per second.
        gravity: Acceleration of free fall (3,) [m/s^2].
        carried: Frames (T,) in which something could carry.
    """
    found = np.zeros(len(centre), dtype=bool)
    size = float(np.linalg.norm(gravity))
    if len(centre) < 3 or size == 0.0:
        return found
    speed = np.diff(centre, axis=0) @ (gravity / size) * fps
    edges = np.diff(np.concatenate([[False], ~carried, [False]]).astype(np.int8))
    for first, end in np.flatnonzero(edges).reshape(-1, 2).tolist():
        # The velocities within the run, and those beside it if it is too short to have two.
        low, high = max(first, 0), min(end - 1, len(speed) - 1)
        if high - low < 2:
            low, high = max(low - 1, 0), min(high + 1, len(speed) - 1)
        high = min(high, len(speed) - 1)
        if high <= low:
            continue
        fall = (speed[high] - speed[low]) * fps / (high - low)
        found[first:end] = fall > (1.0 - SUPPLIED) * size
    return found
