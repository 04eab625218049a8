"""SoftContacts: the samples of people and things under pressure, frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import counted, frames_repr
from halfphysics.errors import InputError
from halfphysics.results.table import Ints, Table

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class SoftContacts(Table):
    """Pressures of a result: columns of one length n, ordered by frame.

    A row is one sample of a surface (a vertex of the skin, or a point of a thing) that presses on a
    layer at the end of frame t. It stands for `area`; the force on it is pressure times area along
    the normal. Numbers are those of single precision, so that files are half as large.

    Attributes:
        frame: The frame t (n,).
        layer: Index into `Result.names` of what is pressed in (n,).
        other: Index into `Result.names` of what presses (n,): an item or a person.
        part: Index into `JOINT_NAMES` of the part that presses (n,); -1: no person.
        vertex: Index into the person's skin of the sample (n,); -1: no skin.
        position: Of the sample in the world (n, 3) [m].
        normal: Unit vector out of the layer, into what presses (n, 3).
        depth: By how much the layer is pressed in (n,) [m]; of soft skin on a soft layer, both
            together.
        pressure: (n,) [Pa].
        area: Of the sample, seen along the normal (n,) [m^2].
    """

    NAME: ClassVar[str] = "soft_contacts"
    VECTORS: ClassVar[frozenset[str]] = frozenset({"position", "normal"})
    NUMBERS: ClassVar[frozenset[str]] = frozenset({"depth", "pressure", "area"})
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"position": "m", "depth": "m", "pressure": "Pa", "area": "m2"}
    )

    frame: Ints
    layer: Ints
    other: Ints
    part: Ints
    vertex: Ints
    position: Array
    normal: Array
    depth: Array
    pressure: Array
    area: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("depth", "pressure", "area"):
            values = getattr(self, name)
            if len(values) and values.min() < 0.0:
                raise InputError(
                    f"soft_contacts.{name}: found {values.min():g}, expected 0 or more"
                )

    def __repr__(self) -> str:
        if not len(self):
            return "SoftContacts(none)"
        return (
            f"SoftContacts({counted(len(self), 'row')} in {frames_repr(self.frame)}, pressures up "
            f"to {1e-3 * self.pressure.max():.3g} kPa)"
        )

    @property
    def force(self) -> Array:
        """Force on each sample, along the normal (n, 3) [N]; the layer feels the opposite."""
        result: Array = (self.pressure * self.area)[:, None] * self.normal
        return result

    def at(self, frame: int) -> Self:
        """The rows of one frame."""
        return self[self.frame == frame]
