"""The core's rows of contacts and overlaps, in terms of people, parts and names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import short_repr
from halfphysics.results.inside import Breaches, Inside, deepest_first

if TYPE_CHECKING:
    from halfphysics.results.table import Ints
    from halfphysics.simulation.coordinates import Person

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactRows:
    """The contacts of one frame; arrays of one length n, one row per pair and side.

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

    __repr__ = short_repr


class Named(Protocol):
    """A `World`, or another that names its shapes."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def people(self) -> tuple[Person, ...]: ...
    @property
    def static_name(self) -> NDArray[np.int64]: ...
    @property
    def shape_name(self) -> NDArray[np.int64]: ...
    @property
    def shape_part(self) -> NDArray[np.int64]: ...


def contact_rows(world: Named, rows: Array) -> tuple[ContactRows, NDArray[np.int64]]:
    """Contacts in terms of people and names, from the core's rows (n, 12).

    Where two people touch, each has a row of its own, with opposite normal and impulse.

    Returns:
        The contacts (m,), and for each the row it comes from (m,).
    """
    shape, static, shape2 = rows[:, :3].astype(np.int64).T
    # The core's rows have either a static or a second shape: what is read at index -1 is not used.
    static_name = world.static_name if len(world.static_name) else np.array([-1])
    shape_name, shape_part = world.shape_name, world.shape_part
    first_person = len(world.names) - len(world.people)
    name, part = shape_name[shape], shape_part[shape]
    fixed = static >= 0
    other = np.where(fixed, static_name[static], shape_name[shape2])
    other_part = np.where(fixed, -1, shape_part[shape2])
    human = name >= first_person
    both = human & (other >= first_person)
    if not both.any():  # as in most frames: each row stays one
        contacts = ContactRows(
            person=np.where(human, name - first_person, -1),
            part=part,
            subject=np.where(human, -1, name),
            other=other,
            other_part=other_part,
            position=rows[:, 3:6].copy(),
            normal=rows[:, 6:9].copy(),
            impulse=rows[:, 9:12].copy(),
        )
        return contacts, np.arange(len(rows))

    row = np.repeat(np.arange(len(rows)), 1 + both)
    twin = np.zeros(len(row), dtype=bool)
    twin[1:] = row[1:] == row[:-1]
    mine, its = np.where(twin, other[row], name[row]), np.where(twin, name[row], other[row])
    human = human[row]
    sign = np.where(twin, -1.0, 1.0)[:, None]
    return ContactRows(
        person=np.where(human, mine - first_person, -1),
        part=np.where(twin, other_part[row], part[row]),
        subject=np.where(human, -1, mine),
        other=its,
        other_part=np.where(twin, part[row], other_part[row]),
        position=rows[row, 3:6],
        normal=sign * rows[row, 6:9],
        impulse=sign * rows[row, 9:12],
    ), row


def inside_rows(world: Named, rows: Array, frame: Ints) -> Inside:
    """The core's rows in terms of people, parts and names.

    Several shapes of one part in one item are one row: the deepest counts.

    Args:
        world: The world whose core gave the rows.
        rows: Shape, static or -1, other shape or -1, and depth [m], 0 where no way out was found:
            (n, 4).
        frame: The frame of every row (n,).
    """
    return Inside(**_overlaps(world, rows, frame)) if len(rows) else Inside.none()


def breach_rows(world: Named, rows: Array, frame: Ints) -> Breaches:
    """As `inside_rows`, of overlaps that should not be."""
    return Breaches(**_overlaps(world, rows, frame)) if len(rows) else Breaches.none()


def _overlaps(world: Named, rows: Array, frame: Ints) -> dict[str, NDArray[Any]]:
    shape, static, shape2 = rows[:, :3].astype(np.int64).T
    # One more entry for index -1: a row has either a static or a second shape.
    static_name, shape_name = np.append(world.static_name, -1), np.append(world.shape_name, -1)
    first_person = len(world.names) - len(world.people)
    name = world.shape_name[shape]
    human = name >= first_person
    columns = {
        "frame": frame,
        "person": np.where(human, name - first_person, -1),
        "part": world.shape_part[shape],
        "subject": np.where(human, -1, name),
        "other": np.where(static >= 0, static_name[static], shape_name[shape2]),
        "depth": rows[:, 3],
    }
    keys = np.stack([columns[k] for k in ("frame", "person", "part", "subject", "other")])
    order = np.lexsort((-deepest_first(rows[:, 3]), *keys[::-1]))
    keys = keys[:, order]
    new = np.append(True, (keys[:, 1:] != keys[:, :-1]).any(axis=0))
    return {k: values[order[new]] for k, values in columns.items()}
