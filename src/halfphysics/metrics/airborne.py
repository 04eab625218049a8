"""Frames in which a motion is airborne: nothing carries it, and it falls as it should."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.metrics.argument_checks import Array

#: Acceleration of free fall on earth [m/s^2].
GRAVITY = 9.81
#: Frequency above which accelerations of the centre of mass are noise [Hz], as in gait analysis
#: (Winter 2009, section 3.4.4).
CUTOFF = 6.0
#: A motion falls where its centre of mass accelerates down by at least this share of gravity. Half:
#: the filter turns the step from standing to flight into a slope whose middle this is.
FALLING = 0.5
#: The lowest skin rests where it is slower than this [m/s] on average over this time [s], before
#: and after. At the top of a jump the mean over 0.1 s is 0.49 m/s; where gravity is another, in
#: proportion.
SLOW, REST = 0.25, 0.1
#: Skin within this of the lowest vertex is the lowest skin [m].
LOWEST = 0.01


def centre_of_mass(motion: Any, body: Any) -> Array:
    """Centre of mass of a person (T, 3) [m], from the masses of the 55 rigid parts."""
    positions, turns = body.joint_frames(motion)
    parts = body.variant.parts
    mass = np.array([part.mass for part in parts])
    own = np.array([part.com for part in parts])
    centres = positions + rot.rotate(turns, np.broadcast_to(own, positions.shape))
    whole: Array = np.einsum("j,tjx->tx", mass / mass.sum(), centres)
    return whole


def free_fall(scene: Any) -> float:
    """Acceleration of free fall in a scene [m/s^2]; without gravity, or a scene, the earth's."""
    size = GRAVITY if scene is None else float(np.linalg.norm(scene.gravity))
    return size if size > 0.0 else GRAVITY


def airborne(motion: Any, body: Any, gravity: float = GRAVITY) -> NDArray[np.bool_]:
    """Frames (T,) in which a motion is in the air by itself: in a jump, between steps of a run.

    Its centre of mass, low-passed at 6 Hz without a phase, accelerates down by more than half of
    gravity, and its lowest skin does not rest; from there it goes on while it accelerates down
    at all and the lowest skin moves, 0.1 s at most, as the filter rounds the ends of a flight. No
    surface is asked about, so that a clip that is sunk, floats or climbs stairs gives the same
    frames. A person who is moved through the air without falling is not airborne: something must
    carry them.

    Args:
        motion: T frames; too few to accelerate (under 4) are not airborne.
        body: The body whose masses and skin count.
        gravity: Acceleration of free fall, down z [m/s^2].
    """
    frames = len(motion)
    found = np.zeros(frames, dtype=bool)
    if frames < 4:
        return found
    fps = float(motion.fps)
    height = smoothed(centre_of_mass(motion, body)[:, 2], fps)
    rises = np.gradient(np.gradient(height)) * fps**2
    count, slow = max(1, round(REST * fps)), SLOW * gravity / GRAVITY
    for t in np.flatnonzero(rises < -FALLING * gravity).tolist():
        found[t] = max(_speeds(motion, body, t, count)) >= slow
    # The filter takes the ends of a flight: it goes on while it falls at all and its skin moves.
    for step in (-1, 1):
        for t in np.flatnonzero(found & ~np.roll(found, -step)).tolist():
            for end in range(t + step, t + step * (count + 1), step):
                if (
                    not 0 <= end < frames
                    or rises[end] >= 0.0
                    or min(_speeds(motion, body, end, 1)) < slow
                ):
                    break
                found[end] = True
    return found


def _speeds(motion: Any, body: Any, frame: int, count: int) -> tuple[float, float]:
    """Mean speeds of the slowest of the lowest skin over `count` frames before and after [m/s]."""
    first, last = max(frame - count, 0), min(frame + count, len(motion) - 1)
    before, here, after = body.vertices(motion, [first, frame, last])
    low = here[:, 2] < here[:, 2].min() + LOWEST
    ways = (
        np.linalg.norm(here[low] - before[low], axis=1) / max(frame - first, 1),
        np.linalg.norm(after[low] - here[low], axis=1) / max(last - frame, 1),
    )
    slowest = int(np.maximum(*ways).argmin())
    return float(ways[0][slowest] * motion.fps), float(ways[1][slowest] * motion.fps)


def smoothed(values: Array, fps: float, cutoff: float = CUTOFF) -> Array:
    """Values (T, ...) low-passed along time without a phase: Butterworth, second order, twice."""
    from scipy.signal import butter, filtfilt

    if cutoff >= 0.5 * fps:
        return values
    b, a = butter(2, cutoff / (0.5 * fps))
    result: Array = filtfilt(b, a, values, axis=0, padlen=min(len(values) - 1, round(fps)))
    return result
