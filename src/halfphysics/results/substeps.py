"""Every committed pose of a run, where settings ask for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.copying import FrozenMapping, ReadOnly
from halfphysics.base.short_repr import counted
from halfphysics.base.validation import frame_rate
from halfphysics.motion.motion import Motion

if TYPE_CHECKING:
    from halfphysics.results.result import ObjectTrack

Array = NDArray[np.float64]


def _set(instance: Any, name: str, value: Any) -> None:
    object.__setattr__(instance, name, value)


def at_substeps(motion: Motion, translation: Array, rotations: Array, fps: float) -> Motion:
    """A person's poses at all substeps, `fps` per second; arguments as of `Motion.with_frames`.

    Poses that are set from outside may jump.
    """
    # These poses are no reference motion: the speed of the root is not checked.
    poses = motion.with_frames(translation, rotations, fps=1.0)
    _set(poses, "fps", frame_rate(fps))
    return poses


@dataclass(frozen=True, kw_only=True, eq=False)
class Substeps(ReadOnly):
    """Every committed pose of a run with ``Settings(record="substeps")``: S + 1 of them.

    Attributes:
        motions: The people's motions at the substeps, the start first.
        objects: Name -> `ObjectTrack` at the substeps.
    """

    motions: tuple[Motion, ...]
    objects: Mapping[str, ObjectTrack]

    def __repr__(self) -> str:
        first = self.motions[0]
        return (
            f"Substeps({len(first)} poses at {first.fps:g} per second, "
            f"{counted(len(self.motions), 'person', 'people')}, "
            f"{counted(len(self.objects), 'object')})"
        )

    def __post_init__(self) -> None:
        _set(self, "motions", tuple(self.motions))
        _set(self, "objects", FrozenMapping(dict(self.objects)))
