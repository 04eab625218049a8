"""Inside: which parts and objects are inside what, and how deep.

Only what starts inside something can be there later: what starts clear stays clear. What is beyond
a wall as seen from the rest of the body counts as inside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Depths(Table):
    """What is inside what in one frame: columns of one length n, a row a pair.

    Attributes:
        person: Index of the person (n,); -1 where an object is inside something.
        part: Index into `JOINT_NAMES` (n,); -1 where `person` is.
        subject: Index into the names of the object that stands in the part's place (n,), -1
            where a person does.
        other: Index into the names of the static, or of the object, that it is inside of (n,).
        depth: How deep (n,) [m]: the way that its deepest shape has to go to be out. 0: no way
            out was found.
    """

    NAME: ClassVar[str] = "inside"
    NUMBERS: ClassVar[frozenset[str]] = frozenset({"depth"})

    person: Ints
    part: Ints
    subject: Ints
    other: Ints
    depth: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self) and self.depth.min() < 0.0:
            raise InputError(f"inside.depth: found {self.depth.min():g}, expected 0 or more [m]")

    @property
    def no_way_out(self) -> NDArray[np.bool_]:
        """Rows (n,) for which no way out was found: free to move until clear by itself."""
        result: NDArray[np.bool_] = self.depth == 0.0
        return result

    def described(self, names: Sequence[str], people: int = 1) -> list[str]:
        """Each row in words, the deepest first, such as "left_foot 34 mm inside floor".

        Args:
            names: What `subject` and `other` refer to.
            people: How many there are: of several each part says whose it is.
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
            # Tenths where whole millimetres would say nothing.
            shown = f"{millimetres:.0f}" if millimetres >= 10.0 else f"{millimetres:.1f}"
            where = f"inside {names[self.other[row]]}"
            lost = self.no_way_out[row]
            words.append(
                f"{what} {where} (no way out found)" if lost else f"{what} {shown} mm {where}"
            )
        return words


@dataclass(frozen=True, kw_only=True, eq=False)
class Inside(Depths):
    """What was inside what over a whole result: as `Depths`, ordered by frame.

    Attributes:
        frame: The frame (n,).
    """

    frame: Ints

    def at(self, frame: int) -> Depths:
        """The rows of one frame."""
        rows = self[self.frame == frame]
        return Depths(**{name: getattr(rows, name) for name in Depths.columns()})


def deepest_first(depth: Array) -> Array:
    """Depths to sort by: what has no way out is deeper than all that has one."""
    return np.where(depth == 0.0, np.inf, depth)
