"""Contacts: pairs in contact, with position, normal and impulse."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted, frames_repr
from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Contacts(Table):
    """Contacts of a result: columns of one length n, ordered by frame.

    A row is one pair of shapes that touched during (t-1, t], in one direction: a part or an object
    may have several shapes, and where normals differ by over 18 degrees a pair has a row for each
    direction. If two people touch, each has a row.

    Attributes:
        frame: The frame t (n,).
        person: Index into `Result.people` (n,); -1 where an object touches a static or object.
        part: Index into `JOINT_NAMES` (n,); -1 where `person` is.
        other: Index into `Result.names` of the touched item or person (n,).
        position: Position of the contact in the world (n, 3) [m].
        normal: Unit vector from the other into the part (n, 3).
        impulse: Impulse on the part, summed over (t-1, t] (n, 3) [N s].
        subject: Index into `Result.names` of the object in place of a part (n,), -1 for a person.
        other_part: Index into `JOINT_NAMES` of the other's part (n,) where the other is a person,
            else -1.
    """

    NAME: ClassVar[str] = "contacts"
    VECTORS: ClassVar[frozenset[str]] = frozenset({"position", "normal", "impulse"})
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType({"position": "m", "impulse": "N s"})

    frame: Ints
    person: Ints
    part: Ints
    other: Ints
    position: Array
    normal: Array
    impulse: Array
    subject: Ints
    other_part: Ints

    def __repr__(self) -> str:
        if not len(self):
            return "Contacts(none)"
        parts = counted(len(np.unique(self.part[self.part >= 0])), "part")
        return (
            f"Contacts({counted(len(self), 'row')} in {frames_repr(self.frame)}, {parts}, "
            f"impulses up to {self.strength.max():.3g} N s)"
        )

    @property
    def strength(self) -> Array:
        """Size of the impulses (n,) [N s]."""
        result: Array = np.linalg.norm(self.impulse, axis=1)
        return result
