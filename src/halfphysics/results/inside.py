"""Overlaps: parts and objects that are inside other items, and their depths.

Only bodies that overlap at the start can overlap later: bodies that start clear stay clear. A part
beyond a wall, as seen from the rest of the body, counts as inside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted, frames_repr
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Depths(Table):
    """Overlaps in one frame: columns of one length n, one row per pair.

    Attributes:
        person: Index of the person (n,); -1 for an object.
        part: Index into `JOINT_NAMES` (n,); -1 where `person` is.
        subject: Index into the names of the object in place of a part (n,), -1 for a person.
        other: Index into the names of the static or object that contains it (n,).
        depth: Depth (n,) [m]: the distance of its deepest shape to the exit. 0: no exit was
            found.
    """

    NAME: ClassVar[str] = "inside"
    NUMBERS: ClassVar[frozenset[str]] = frozenset({"depth"})
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType({"depth": "m"})

    person: Ints
    part: Ints
    subject: Ints
    other: Ints
    depth: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self) and self.depth.min() < 0.0:
            raise InputError(f"inside.depth: found {self.depth.min():g}, expected 0 or more [m]")

    def __repr__(self) -> str:
        if not len(self):
            return f"{type(self).__name__}(none)"
        frame = getattr(self, "frame", None)
        when = "" if frame is None else f" in {frames_repr(frame)}"
        deepest = f"up to {1000.0 * self.depth.max():.3g} mm deep"
        return f"{type(self).__name__}({counted(len(self), 'row')}{when}, {deepest})"

    @property
    def no_way_out(self) -> NDArray[np.bool_]:
        """Rows (n,) without an exit: such parts move freely until they are clear."""
        result: NDArray[np.bool_] = self.depth == 0.0
        return result

    def described(self, names: Sequence[str], people: int = 1) -> list[str]:
        """Each row in words, the deepest first, such as "left_foot 34 mm inside floor".

        Args:
            names: Names to which `subject` and `other` refer.
            people: Number of people; with several, each part is named with its person.
        """
        words = []
        for row in np.argsort(-deepest_first(self.depth), kind="stable"):
            person = int(self.person[row])
            if person < 0:
                what = names[self.subject[row]]
            else:
                whose = f"{names[len(names) - people + person]}'s " if people > 1 else ""
                what = whose + JOINT_NAMES[self.part[row]]
            millimetres = 1000.0 * self.depth[row]
            # Tenths where whole millimetres would round to zero.
            shown = f"{millimetres:.0f}" if millimetres >= 10.0 else f"{millimetres:.1f}"
            where = f"inside {names[self.other[row]]}"
            lost = self.no_way_out[row]
            words.append(
                f"{what} {where} (no way out found)" if lost else f"{what} {shown} mm {where}"
            )
        return words


@dataclass(frozen=True, kw_only=True, eq=False)
class Inside(Depths):
    """Overlaps over a whole result: as `Depths`, ordered by frame.

    Attributes:
        frame: The frame (n,).
    """

    frame: Ints

    __repr__ = Depths.__repr__

    def at(self, frame: int) -> Depths:
        """The rows of one frame."""
        rows = self[self.frame == frame]
        found = Depths(**{name: getattr(rows, name) for name in Depths.columns()})
        return found if self.naming is None else found.named(self.naming)


@dataclass(frozen=True, kw_only=True, eq=False)
class Breaches(Inside):
    """Overlaps that must not be: of bodies that were clear, at any committed pose of a frame.

    As `Inside`; the depth is the largest of the frame. Empty unless the promise was broken that
    what starts clear stays clear.
    """

    NAME: ClassVar[str] = "breaches"

    __repr__ = Depths.__repr__


def deepest_first(depth: Array) -> Array:
    """Depths as sort keys: rows without an exit are deeper than all others."""
    return np.where(depth == 0.0, np.inf, depth)
