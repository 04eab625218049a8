"""Data of a motion file besides the motion, kept to be written back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.motion.resampling import neighbours

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class FileMetadata(ReadOnly):
    """Data of a motion file besides the motion: all that a writer needs to restore it.

    `fields` belongs to the format (key names, dtypes, constants); `per_frame` holds arrays
    with one row per frame that are cut and resampled along with the motion.
    """

    format: str
    fields: Mapping[str, Any] = field(default_factory=dict)
    per_frame: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    __repr__ = short_repr

    def taken(self, rows: slice, frames: int) -> FileMetadata:
        """The same with the per-frame arrays indexed by `rows`, of so many frames; "first", the
        number of the first one in its video, goes along. Backwards it is that of the earliest."""
        per_frame = {key: value[rows] for key, value in self.per_frame.items()}
        kept = range(frames)[rows]
        fields = self._numbered(min(kept, default=0), abs(kept.step))
        return FileMetadata(format=self.format, fields=fields, per_frame=per_frame)

    def sampled(self, position: Array) -> FileMetadata:
        """The same with the per-frame arrays at even fractional frames `position` (T,), T >= 2."""
        low, high, weight = neighbours(position)
        per_frame = {}
        for key, value in self.per_frame.items():
            if value.dtype.kind == "f":
                w = weight.reshape(-1, *[1] * (value.ndim - 1))
                mixed = (1.0 - w) * value[low] + w * value[high]
                per_frame[key] = mixed.astype(value.dtype)
            else:
                per_frame[key] = value[np.where(weight < 0.5, low, high)]
        fields = self._numbered(0, float(position[1] - position[0]))
        return FileMetadata(format=self.format, fields=fields, per_frame=per_frame)

    def _numbered(self, start: int, step: float) -> Mapping[str, Any]:
        """The fields of a clip from frame `start` on whose frames are `step` of these apart: the
        number of the first one is counted in a video of such frames."""
        first = self.fields.get("first")
        if not isinstance(first, int):
            return self.fields
        # Halves go up, all of them: people stay as far apart.
        return {**self.fields, "first": math.floor((first + start) / step + 0.5)}
