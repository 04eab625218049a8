"""Contacts: who touched what, where and how hard."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Contacts(Table):
    """Who touched what, where and how hard: columns of one length n, ordered by frame.

    A row is one pair that touched during (t-1, t]. Where two people touch, each has a row.

    Attributes:
        frame: The frame t (n,).
        person: Index into `Result.people` (n,); -1 where an object touches a static or object.
        part: Index into `JOINT_NAMES` (n,); -1 where `person` is.
        other: Index into `Result.names` of what was touched (n,).
        position: Where, in the world (n, 3) [m].
        normal: Unit vector from the other into the part (n, 3).
        impulse: On the part, summed over (t-1, t] (n, 3) [N s].
        subject: Index into `Result.names` of the object that stands in the part's place (n,),
            -1 where a person does.
        other_part: Index into `JOINT_NAMES` of the other's part (n,) where the other is a person,
            else -1.
    """

    NAME: ClassVar[str] = "contacts"
    VECTORS: ClassVar[frozenset[str]] = frozenset({"position", "normal", "impulse"})

    frame: Ints
    person: Ints
    part: Ints
    other: Ints
    position: Array
    normal: Array
    impulse: Array
    subject: Ints
    other_part: Ints

    @property
    def strength(self) -> Array:
        """Size of the impulses (n,) [N s]."""
        result: Array = np.linalg.norm(self.impulse, axis=1)
        return result
