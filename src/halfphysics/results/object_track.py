"""ObjectTrack: where an object is in every frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import counted, numbers
from halfphysics.errors import InputError
from halfphysics.motion.pose import checked

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ObjectTrack(ReadOnly):
    """Poses of an object: `position` (T, 3) [m] and `quaternion` (T, 4) of its own frame."""

    position: Array
    quaternion: Array

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "position", checked("position", self.position, (None, 3), "(T, 3)")
        )
        object.__setattr__(
            self, "quaternion", checked("quaternion", self.quaternion, (None, 4), "(T, 4)")
        )
        if len(self.position) != len(self.quaternion):
            raise InputError(
                f"position has {len(self.position)} frames and quaternion {len(self.quaternion)}; "
                "expected the same number"
            )

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        ends = f"{numbers(self.position[0])} to {numbers(self.position[-1])} m" if len(self) else ""
        return f"ObjectTrack({counted(len(self), 'frame')}, {ends})"
