"""Velocities and accelerations of sampled motion, by central differences and a low-pass filter.

Positions of recorded motion carry noise of about a millimetre, which two differences turn into
tens of m/s^2. As in biomechanics, velocities pass a Butterworth filter forwards and backwards, so
that nothing is delayed (Winter, Biomechanics and Motor Control of Human Movement, 2009, 3.4.4).
"""

from __future__ import annotations

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


def low_pass(values: Array, fps: float, cutoff: float | None) -> Array:
    """Samples (n, ...) without what is faster than `cutoff` [Hz], undelayed; None: as they are.

    Beyond both ends the samples are continued by their own, turned by 180 degrees about the end
    point. Samples at under twice the cut-off hold nothing faster: they come back as they are.
    """
    nyquist = 0.5 * fps
    if cutoff is None or len(values) < 2 or TWICE * cutoff >= nyquist:
        return values
    from scipy.signal import butter, sosfiltfilt

    sections = butter(ORDER, TWICE * cutoff / nyquist, output="sos")
    pad = min(len(values) - 1, int(np.ceil(PADDING * fps)))
    flat = values.reshape(len(values), -1)
    result: Array = np.zeros_like(flat)
    moving = np.flatnonzero((flat != flat[0]).any(axis=0))
    result[:] = flat[0]
    if len(moving):
        result[:, moving] = sosfiltfilt(sections, flat[:, moving], axis=0, padlen=pad)
    return result.reshape(values.shape)


def rates(steps: Array, fps: float, cutoff: float | None) -> tuple[Array, Array]:
    """Velocities and accelerations at T frames, from the T - 1 displacements between them.

    Args:
        steps: Displacements from frame to frame (T - 1, ...) [m or rad].
        fps: Frames per second.
        cutoff: Of the low-pass filter [Hz]; None: no filter.

    Returns:
        Velocity and acceleration (T, ...), both exact where the acceleration is constant. One
        frame is at rest; two frames have one velocity and no acceleration.
    """
    if len(steps) == 0:
        still = np.zeros((1, *steps.shape[1:]))
        return still, still.copy()
    speed = low_pass(steps * fps, fps, cutoff)
    first, last = speed[:1], speed[-1:]
    if len(speed) > 1:
        first, last = 2.0 * speed[:1] - speed[1:2], 2.0 * speed[-1:] - speed[-2:-1]
    between = np.concatenate([first, speed, last])
    return 0.5 * (between[1:] + between[:-1]), np.diff(between, axis=0) * fps


def turns(quaternions: Array) -> Array:
    """Rotation vectors (T - 1, ..., 3) [rad] from frame to frame, in the world.

    Args:
        quaternions: World from body, shape (T, ..., 4).
    """
    return rot.log(rot.multiply(quaternions[1:], rot.conjugate(quaternions[:-1])))
