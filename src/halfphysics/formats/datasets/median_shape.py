"""One shape of a person from betas that a file has for every frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.formats.checked_fields import Record

Array = NDArray[np.float64]

#: Betas of one person differ by less than this over the frames.
SAME_SHAPE = 1e-3


def median_shape(record: Record, frames: int, key: str = "betas") -> Array | None:
    """Betas (n,): of (n,) or (1, n) as they are, of (frames, n) the median.

    Args:
        record: The fields of a person.
        frames: Number of frames of the whole file.
        key: The field with the betas.

    Returns:
        The betas; None: the file has none. Of any other shape, as they are: `motion_of` refuses.

    Warns:
        HalfPhysicsWarning: The shape changes over the frames.

    Raises:
        FileError: NaN, or no numbers.
    """
    if key not in record:
        return None
    betas = record.array(key, *[None] * len(record.shape(key)))
    if betas.ndim != 2 or len(betas) != frames:
        return betas
    middle = np.median(betas, axis=0)
    off = float(np.abs(betas - middle).max(initial=0.0))
    if off > SAME_SHAPE:
        warn(
            f"{record.where}: field '{key}': the shape changes over the frames by up to {off:.2g}; "
            "the median is taken"
        )
    return np.asarray(middle)
