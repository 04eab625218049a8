"""Flights: frames in which a person falls freely, in a jump or from something."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Share of the weight that may be supplied in the middle of a flight's frames.
SUPPLIED = 0.3


def flights(centre: Array, fps: float, gravity: Array, carried: Mask) -> Mask:
    """Frames (T,) of flights.

    A flight is a run of frames in which nothing is near enough to carry and the centre of mass
    falls as gravity has it, to `SUPPLIED`, by the median of its accelerations: whoever floats is
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
    for first, end in runs(~carried):
        # Steps within the run, and those beside it if it is too short to have two.
        low, high = first, end - 1
        if high - low < 2:
            low, high = max(first - 1, 0), min(end, len(speed))
        if high - low >= 2:
            fall = np.median(np.diff(speed[low:high])) * fps
            found[first:end] = fall > (1.0 - SUPPLIED) * size
    return found


def runs(mask: Mask) -> list[tuple[int, int]]:
    """First frame and end of every run of True in a mask (T,)."""
    edges = np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))
    return [(int(first), int(end)) for first, end in np.flatnonzero(edges).reshape(-1, 2)]
