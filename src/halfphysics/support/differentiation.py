"""Velocities and accelerations of sampled motion, by central differences and a low-pass filter.

Positions of recorded motion carry noise of about a millimetre, which two differences turn into
tens of m/s^2. As in biomechanics, velocities pass a Butterworth filter forwards and backwards, so
that nothing is delayed (Winter, Biomechanics and Motor Control of Human Movement, 2009, 3.4.4).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot

Array = NDArray[np.float64]

#: Order of the Butterworth filter; it runs twice, so its slope is that of twice the order.
ORDER = 2
#: The cut-off is raised by this, so that both passes together have lost 3 dB at the frequency
#: asked for: (sqrt(2) - 1)^(-1 / (2 ORDER)) (Winter 2009, 3.4.4.2).
TWICE = (np.sqrt(2.0) - 1.0) ** (-0.5 / ORDER)
#: Time by which samples are continued beyond the ends, turned about their end point [s].
PADDING = 0.5
#: Fewest frames of a flight: two velocities, of which an acceleration comes.
SHORTEST = 3


def low_pass(values: Array, fps: float, cutoff: float | None) -> Array:
    """Samples (n, ...) without what is faster than `cutoff` [Hz], undelayed; None: as they are.

    The straight line from the first sample to the last one passes as it is: few samples, such as
    those of a short flight, are too short for a filter to find a slope in. Beyond both ends what is
    left is continued by its own, turned by 180 degrees about the end point. Samples at under twice
    the cut-off hold nothing faster: they come back as they are.
    """
    nyquist = 0.5 * fps
    if cutoff is None or len(values) < 2 or TWICE * cutoff >= nyquist:
        return values
    from scipy.signal import butter, sosfiltfilt

    sections = butter(ORDER, TWICE * cutoff / nyquist, output="sos")
    pad = min(len(values) - 1, int(np.ceil(PADDING * fps)))
    flat = values.reshape(len(values), -1)
    share = np.linspace(0.0, 1.0, len(values))[:, None]
    result: Array = flat[0] + share * (flat[-1] - flat[0])
    moving = np.flatnonzero((flat != flat[0]).any(axis=0))
    if len(moving):
        rest = flat[:, moving] - result[:, moving]
        result[:, moving] += sosfiltfilt(sections, rest, axis=0, padlen=pad)
    return result.reshape(values.shape)


def rates(
    steps: Array,
    fps: float,
    cutoff: float | None,
    flights: Sequence[tuple[int, int]] = (),
) -> tuple[Array, Array]:
    """Velocities and accelerations at T frames, from the T - 1 displacements between them.

    Accelerations jump where a flight begins and ends. A filter would spread the forces of take-off
    and landing into it, so that flights and what is between them are filtered each by itself.

    Args:
        steps: Displacements from frame to frame (T - 1, ...) [m or rad].
        fps: Frames per second.
        cutoff: Of the low-pass filter [Hz]; None: no filter.
        flights: First frame and end of each; those under `SHORTEST` frames do not count.

    Returns:
        Velocity and acceleration (T, ...), both exact where the acceleration is constant. One
        frame is at rest; two frames have one velocity and no acceleration.
    """
    if len(steps) == 0:
        still = np.zeros((1, *steps.shape[1:]))
        return still, still.copy()
    count = len(steps) + 1
    velocity, acceleration = (
        np.empty((count, *steps.shape[1:])),
        np.empty((count, *steps.shape[1:])),
    )
    for first, end, inner in segments(count, flights):
        # Steps beside what is between flights belong to it: they are partly of its own.
        low, high = (first, end - 1) if inner else (max(first - 1, 0), min(end, count - 1))
        between = _extended(low_pass(steps[low:high] * fps, fps, cutoff))
        between = between[first - low : first - low + end - first + 1]
        velocity[first:end] = 0.5 * (between[1:] + between[:-1])
        acceleration[first:end] = np.diff(between, axis=0) * fps
    return velocity, acceleration


def segments(count: int, flights: Sequence[tuple[int, int]]) -> list[tuple[int, int, bool]]:
    """First frame, end, and whether it is a flight, of what `count` frames are divided into."""
    found, at = [], 0
    for first, end in flights:
        if end - first < SHORTEST:
            continue
        if first > at:
            found.append((at, first, False))
        found.append((first, end, True))
        at = end
    return [*found, (at, count, False)] if at < count else found


def _extended(speed: Array) -> Array:
    """Velocities (n, ...) with one more at each end, on the line through the last two."""
    first, last = speed[:1], speed[-1:]
    if len(speed) > 1:
        first, last = 2.0 * speed[:1] - speed[1:2], 2.0 * speed[-1:] - speed[-2:-1]
    return np.concatenate([first, speed, last])


def turns(quaternions: Array) -> Array:
    """Rotation vectors (T - 1, ..., 3) [rad] from frame to frame, in the world.

    Args:
        quaternions: World from body, shape (T, ..., 4).
    """
    return rot.log(rot.multiply(quaternions[1:], rot.conjugate(quaternions[:-1])))
