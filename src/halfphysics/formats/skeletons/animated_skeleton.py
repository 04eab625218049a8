"""A skeleton in motion as the readers of BVH and glTF give it: what retargeting needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class AnimatedSkeleton:
    """Joints over T frames, in the file's unit and axes.

    At the zero pose all joint frames are parallel to the axes of `offsets`; the world of
    `positions` and `quaternions` may be turned against them.

    Attributes:
        names: Names of the J joints, parents before children.
        parents: Parent joints (J,), -1 for the root.
        offsets: Positions in the parents' frames, (J, 3).
        ends: Joint -> the place where its bone ends, in its frame, for joints without children.
        positions: World positions (T, J, 3).
        quaternions: World from joint (T, J, 4).
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Array
    ends: dict[int, Array]
    positions: Array
    quaternions: Array
