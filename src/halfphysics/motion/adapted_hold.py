"""AdaptedHold: what hands are to hold, when and how hard, and how the thing was recorded."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.motion.pose import checked
from halfphysics.motion.resampling import SAME_TIME, neighbours
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AdaptedHold(ReadOnly):
    """One thing that one person is to hold (`Motion.holds`); frames are those of the motion, T.

    Attributes:
        object: Name of the thing.
        parts: Joints that hold it: wrists, which stand for hand and fingers.
        first: Frame in which they press.
        last: Last frame in which they do.
        force: What each presses with against the other [N]; 0: fingers hold it, or it is borne
            from below.
        moved: How far each palm was moved from where it was recorded [m], medians over the hold.
        position: Where the thing was recorded in every frame (T, 3) [m].
        quaternion: How it was turned (T, 4), wxyz.

    Raises:
        InputError: A part that is no joint, frames outside the motion, or impossible numbers.
    """

    object: str
    parts: tuple[str, ...]
    first: int
    last: int
    force: float
    moved: tuple[float, ...]
    position: Array = field(repr=False)
    quaternion: Array = field(repr=False)

    __repr__ = short_repr

    def __post_init__(self) -> None:
        what = f"hold of {shown(self.object)}"
        if not isinstance(self.object, str) or not self.object:
            raise InputError(f"{what}: expected the name of an object")
        parts = tuple(self.parts)
        for part in parts:
            if not isinstance(part, str) or part not in JOINT_INDEX:
                raise InputError(f"{what}: found part {shown(part)}, expected one of JOINT_NAMES")
        moved = tuple(number(m, f"{what}: moved", least=0.0, unit="m") for m in self.moved)
        if not parts or len(moved) != len(parts):
            raise InputError(
                f"{what}: found {len(parts)} parts and {len(moved)} distances moved; expected one "
                "distance for each of one part or more"
            )
        position = checked(f"{what}: position", self.position, (None, 3), "(T, 3)")
        quaternion = checked(
            f"{what}: quaternion", self.quaternion, (len(position), 4), f"({len(position)}, 4)"
        )
        frames = self.first, self.last
        whole = all(is_whole(frame, least=0, plain=False) for frame in frames)
        if not (whole and self.first <= self.last < len(position)):
            raise InputError(
                f"{what}: found frames {shown(self.first)} to {shown(self.last)}, expected two of "
                f"0 to {len(position) - 1}, the earlier one first"
            )
        for name, value in (
            ("parts", parts),
            ("first", int(self.first)),
            ("last", int(self.last)),
            ("force", number(self.force, f"{what}: force", least=0.0, unit="N")),
            ("moved", moved),
            ("position", position),
            ("quaternion", quaternion),
        ):
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        """Number of frames of the motion, T."""
        return len(self.position)

    def during(self, at: Array) -> NDArray[np.intp]:
        """Which of some fractional frames (K,) are in the hold, to rounding."""
        return np.flatnonzero((at > self.first - SAME_TIME) & (at < self.last + SAME_TIME))

    def poses(self, at: Array) -> tuple[Array, Array]:
        """Recorded positions (K, 3) [m] and quaternions (K, 4) at fractional frames (K,)."""
        low, high, weight = neighbours(at)
        between, w = weight > 0.0, weight[:, None]
        turned = self.quaternion[low]
        turned[between] = rot.slerp(
            self.quaternion[low[between]], self.quaternion[high[between]], weight[between]
        )
        return (1.0 - w) * self.position[low] + w * self.position[high], turned

    def sampled(self, at: Array) -> AdaptedHold | None:
        """The hold in a motion of these fractional frames (K,); None: it is in none of them."""
        during = self.during(at)
        if not len(during):
            return None
        return AdaptedHold(
            self.object,
            self.parts,
            int(during[0]),
            int(during[-1]),
            self.force,
            self.moved,
            *self.poses(at),
        )


def check_adaptation(motion: Motion) -> None:
    """Refuse holds, or a motion as recorded, of other frames than the motion's.

    Raises:
        InputError: They are.
    """
    for hold in motion.holds:
        if not isinstance(hold, AdaptedHold) or len(hold) != len(motion):
            raise InputError(
                f"holds: found {shown(hold)}, expected an AdaptedHold of {len(motion)} frames"
            )
    recorded = motion.recorded
    if recorded is None:
        return
    if not isinstance(recorded, type(motion)) or recorded.recorded is not None or recorded.holds:
        raise InputError(f"recorded: found {shown(recorded)}, expected a motion as recorded")
    if len(recorded) != len(motion) or recorded.fps != motion.fps:
        raise InputError(
            f"recorded: found {len(recorded)} frames at {recorded.fps:g} fps, expected "
            f"{len(motion)} at {motion.fps:g} as the motion"
        )
