"""Resampling of a motion: frames at fractional positions of another frame rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError

Array = NDArray[np.float64]

#: A sample this near to a source frame [frames] is that frame: rounding of k * fps_old / fps_new.
SAME_TIME = 1e-6
#: Rates of television as they are said and as they are (23.976, 24000 / 1001) differ by less than
#: this part. Between such rates, and multiples of them, a last sample this part of a frame after
#: the last frame is that frame.
_SAME_RATE, _LAST = 2e-6, 0.02
#: Highest rate that a motion is resampled to [1/s]: beyond it a minute takes gigabytes, and no
#: camera, no muscle and no substep needs it.
MAX_FPS = 10_000.0


def sample_positions(frames: int, fps: float, new_fps: float) -> Array:
    """Fractional frames (K,) at the times of another rate, from the first frame on.

    Nothing is extrapolated: the last one is at or before the last frame. To a rate that is the
    clip's but for its printed digits every frame stays.

    Raises:
        InputError: `new_fps` is over 10,000, or leaves fewer than two frames.
    """
    if new_fps > MAX_FPS:
        raise InputError(f"fps: found {new_fps:g}, expected at most {MAX_FPS:g} frames per second")
    last = (frames - 1) * new_fps / fps
    slack = min(_SAME_RATE * last, _LAST) if _is_multiple(fps, new_fps) else 0.0
    count = int(np.floor(last + max(SAME_TIME, slack))) + 1
    if count < 2:
        duration = (frames - 1) / fps
        raise InputError(
            f"fps: found {new_fps:g}, which leaves one frame of a clip of {duration:.3g} s; "
            f"expected at least {1.0 / duration:.3g}"
        )
    position: Array = np.minimum(np.arange(count) * (fps / new_fps), frames - 1.0)
    return position


def _is_multiple(fps: float, new_fps: float) -> bool:
    """Whether one rate is a whole multiple of the other but for their printed digits."""
    times = max(fps, new_fps) / min(fps, new_fps)
    return abs(times / round(times) - 1.0) < _SAME_RATE


def interpolated(translation: Array, rotations: Array, position: Array) -> tuple[Array, Array]:
    """Translations (K, 3) and rotations (K, 55, 3) at fractional frames: linear, and SLERP.

    A position that is a frame (to rounding) is copied bit for bit.
    """
    low, high, weight = neighbours(position)
    w = weight[:, None]
    moved = (1.0 - w) * translation[low] + w * translation[high]
    between = weight > 0.0
    turned = rotations[low]
    turned[between] = rot.log(
        rot.slerp(rot.exp(rotations[low[between]]), rot.exp(rotations[high[between]]), w[between])
    )
    return moved, turned


def neighbours(position: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Frames before and after fractional frames, and the weight of the one after."""
    nearest = np.rint(position)
    position = np.where(np.abs(position - nearest) < SAME_TIME, nearest, position)
    low = np.floor(position).astype(np.intp)
    weight = position - low
    return low, low + (weight > 0.0), weight
