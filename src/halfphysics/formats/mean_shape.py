"""One shape of a person from betas that an estimator has for every frame: their mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.reader_warnings import warn
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.rotation_forms import numbers_of

Array = NDArray[np.float64]

#: Betas that stray from their mean by more are told; one unit of the first is centimetres of
#: stature [standard deviations of the shape space].
_VARIES = 0.5


def mean_shape(record: Record, key: str, frames: int) -> Array | None:
    """Betas (n,) of (n,), (1, n) or (frames, n): the mean; None: the file has none.

    Warns:
        HalfPhysicsWarning: They vary a lot over the frames.

    Raises:
        FileError: Another shape, or NaN.
    """
    if key not in record.fields or record.raw(key) is None:
        return None
    betas = numbers_of(record, key)
    if not betas.size:
        return None
    rows = betas.reshape(-1, betas.shape[-1]) if betas.ndim else betas.reshape(1, 1)
    if len(rows) not in (1, frames):
        raise record.error(
            key, f"found shape {betas.shape}, expected (n,), (1, n) or ({frames}, n)"
        )
    mean: Array = rows.mean(axis=0)
    off = float(np.abs(rows - mean).max())
    if off > _VARIES:
        warn(
            f"{record.where}: field '{key}': the shape changes over the frames, by up to {off:.2g} "
            "from its mean, which is taken"
        )
    return mean
