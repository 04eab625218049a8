"""Inside: which parts and objects are inside what, and how deep.

Only what starts inside something can be there later: what starts clear stays clear. What is beyond
a wall as seen from the rest of the body counts as inside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.table import Ints, Table

if TYPE_CHECKING:
    from halfphysics.simulation.world import World

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
        for row in np.argsort(-_deepest_first(self.depth), kind="stable"):
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


def _deepest_first(depth: Array) -> Array:
    """Depths to sort by: what has no way out is deeper than all that has one."""
    return np.where(depth == 0.0, np.inf, depth)


def inside_of(world: World, rows: Array, frame: Ints) -> Inside:
    """The core's rows in terms of people, parts and names.

    Several shapes of one part in one thing are one row: the deepest counts.

    Args:
        world: Whose stepper gave the rows.
        rows: Shape, static or -1, other shape or -1, and depth [m], 0 where no way out was found:
            (n, 4).
        frame: The frame of every row (n,).
    """
    if not len(rows):
        return Inside.none()
    mover, static, mover2 = rows[:, :3].astype(np.int64).T
    # One more entry for index -1: a row has either a static or a second shape.
    static_name, mover_name = np.append(world.static_name, -1), np.append(world.mover_name, -1)
    first_person = len(world.names) - len(world.people)
    name = world.mover_name[mover]
    human = name >= first_person
    columns = {
        "frame": frame,
        "person": np.where(human, name - first_person, -1),
        "part": world.mover_part[mover],
        "subject": np.where(human, -1, name),
        "other": np.where(static >= 0, static_name[static], mover_name[mover2]),
        "depth": rows[:, 3],
    }
    keys = np.stack([columns[k] for k in ("frame", "person", "part", "subject", "other")])
    order = np.lexsort((-_deepest_first(rows[:, 3]), *keys[::-1]))
    keys = keys[:, order]
    new = np.append(True, (keys[:, 1:] != keys[:, :-1]).any(axis=0))
    return Inside(**{k: values[order[new]] for k, values in columns.items()})
