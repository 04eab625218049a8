"""A clip that slides as a whole: the level velocity that all resting soles have in common.

A moving camera that an estimator took for still, or a generator's root that is faster than its
steps, moves planted feet along. What they have in common, all through the clip, is taken off the
root. What differs from foot to foot is left to `planted`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.repair.soles import Soles

Array = NDArray[np.float64]

#: Less than this is how feet roll, not damage [m/s].
LEAST = 0.025
#: It is told from chance where it is as many times its standard error.
_SURE = 4.0
#: Fewer rests than this say nothing.
_RESTS = 3
#: At least this part of all rests, by time, slides alike, to this part of the velocity.
_MOST, _ALIKE = 0.7, 0.5
#: The ends of a rest roll: this part of it is left out at each.
_ROLLS = 0.25
_ROUNDS = 50


def common_slide(people: Sequence[Soles]) -> Array:
    """Level velocity (2,) [m/s] of all resting soles; 0 where there is none in common."""
    found = [_velocity(soles, *phase) for soles in people for phase in soles.phases()]
    velocities = np.array([v for v, _ in found]).reshape(-1, 2)
    lengths = np.array([n for _, n in found])
    if len(velocities) < _RESTS or not lengths.any():
        return np.zeros(2)
    middle = _median(velocities, lengths)
    off = np.linalg.norm(velocities - middle, axis=1)
    spread = float(np.median(off)) / np.sqrt(0.5 * len(velocities))  # heel and toe say the same
    size = float(np.linalg.norm(middle))
    alike = lengths[off < max(LEAST, _ALIKE * size)].sum() >= _MOST * lengths.sum()
    return middle if alike and size > max(LEAST, _SURE * spread) else np.zeros(2)


def _velocity(soles: Soles, patch: int, first: int, end: int) -> tuple[Array, float]:
    """Mean level velocity (2,) [m/s] of the middle of a rest, and its length [s]."""
    cut = int(_ROLLS * (end - first))
    first, end = first + cut, end - cut
    if end - first < 2:
        return np.zeros(2), 0.0
    places = soles.centre[first:end, patch, :2]
    time = np.arange(first, end) / soles.fps
    slope = np.polynomial.polynomial.polyfit(time - time.mean(), places, 1)[1]
    return slope, (end - first) / soles.fps


def _median(points: Array, weights: Array) -> Array:
    """Geometric median (2,) of points (n, 2) with weights (n,) (Weiszfeld 1937)."""
    at = np.average(points, axis=0, weights=weights + 1e-9)
    for _ in range(_ROUNDS):
        share = weights / np.maximum(np.linalg.norm(points - at, axis=1), 1e-6)
        at = (share[:, None] * points).sum(axis=0) / share.sum()
    result: Array = at
    return result


def without_slide(motion: Motion, velocity: Array) -> Motion:
    """The motion without a level velocity (2,) [m/s], where it was at its first frame."""
    time = np.arange(len(motion)) / motion.fps
    translation = np.array(motion.translation)
    translation[:, :2] -= time[:, None] * velocity
    return motion.with_frames(translation, motion.rotations)
