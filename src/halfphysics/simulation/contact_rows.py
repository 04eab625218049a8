"""What touched what in one frame, in terms of people and names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.simulation.world import Person

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touches:
    """What touched what in one frame; arrays of one length n, one row per pair and side.

    Attributes:
        person: Index of the person (n,), -1 where an object touches something that is no person.
        part: Joint index of the part (n,), -1 for objects.
        subject: Index into the names of the object that plays the part's role (n,), else -1.
        other: Index into the names of what was touched (n,).
        other_part: Joint index on the other, where that is a person (n,), else -1.
        position: In the world (n, 3) [m].
        normal: Unit vector from the other into the part (n, 3).
        impulse: On the part, summed over the frame (n, 3) [N s].
    """

    person: NDArray[np.int64]
    part: NDArray[np.int64]
    subject: NDArray[np.int64]
    other: NDArray[np.int64]
    other_part: NDArray[np.int64]
    position: Array
    normal: Array
    impulse: Array


class Named(Protocol):
    """What has names: a `World`."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def people(self) -> tuple[Person, ...]: ...

    static_name: NDArray[np.int64]
    mover_name: NDArray[np.int64]
    mover_part: NDArray[np.int64]


def touches(world: Named, rows: Array) -> tuple[Touches, NDArray[np.int64]]:
    """Contacts in terms of people and names, from the core's rows (n, 12).

    Where two people touch, each has a row of its own, with opposite normal and impulse.

    Returns:
        The contacts (m,), and for each the row it comes from (m,).
    """
    mover, static, mover2 = rows[:, :3].astype(np.int64).T
    # One more entry for index -1: the core's rows have either a static or a second mover.
    static_name = np.append(world.static_name, -1)
    mover_name = np.append(world.mover_name, -1)
    mover_part = np.append(world.mover_part, -1)
    first_person = len(world.names) - len(world.people)
    name, part = mover_name[mover], mover_part[mover]
    fixed = static >= 0
    other = np.where(fixed, static_name[static], mover_name[mover2])
    other_part = np.where(fixed, -1, mover_part[mover2])
    human = name >= first_person
    both = human & (other >= first_person)

    row = np.repeat(np.arange(len(rows)), 1 + both)
    twin = np.zeros(len(row), dtype=bool)
    twin[1:] = row[1:] == row[:-1]
    mine, its = np.where(twin, other[row], name[row]), np.where(twin, name[row], other[row])
    human = human[row]
    sign = np.where(twin, -1.0, 1.0)[:, None]
    return Touches(
        person=np.where(human, mine - first_person, -1),
        part=np.where(twin, other_part[row], part[row]),
        subject=np.where(human, -1, mine),
        other=its,
        other_part=np.where(twin, part[row], other_part[row]),
        position=rows[row, 3:6],
        normal=sign * rows[row, 6:9],
        impulse=sign * rows[row, 9:12],
    ), row
