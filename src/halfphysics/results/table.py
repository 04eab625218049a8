"""Table: columns of one length, the base of a result's tables."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, overload

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.copying import ReadOnly
from halfphysics.base.in_notebook import InNotebook
from halfphysics.errors import InputError
from halfphysics.motion.pose import checked

if TYPE_CHECKING:
    import pandas
    import polars

    from halfphysics.results.naming import Naming

Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Table(InNotebook, ReadOnly):
    """Columns of one length n: whole numbers (n,) unless declared otherwise.

    Raises:
        InputError: Columns of different lengths or of another type.
    """

    NAME: ClassVar[str]  # in messages
    VECTORS: ClassVar[frozenset[str]] = frozenset()  # columns (n, 3) of float64
    NUMBERS: ClassVar[frozenset[str]] = frozenset()  # columns (n,) of float64
    ENDLESS: ClassVar[frozenset[str]] = frozenset()  # those of them that may be inf
    UNITS: ClassVar[Mapping[str, str]] = MappingProxyType({})  # column -> unit

    def __post_init__(self) -> None:
        first = fields(self)[0].name
        n = len(np.atleast_1d(getattr(self, first)))
        for column in self.columns():
            value = getattr(self, column)
            name = f"{self.NAME}.{column}"
            array: NDArray[Any]
            if column in self.VECTORS:
                array = checked(name, value, (None, 3), "(n, 3)")
            elif column in self.NUMBERS:
                endless = column in self.ENDLESS
                array = checked(name, value, (None,), "numbers (n,)", endless=endless)
            else:
                array = _whole(name, value)
            if len(array) != n:
                raise InputError(
                    f"{name}: found {len(array)} rows and {n} in {self.NAME}.{first}; "
                    "expected the same number"
                )
            object.__setattr__(self, column, array)

    @classmethod
    def columns(cls) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(f.name for f in fields(cls))

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

    def __getitem__(self, rows: Any) -> Self:
        """The rows that a slice, a mask (n,) or indices choose."""
        if isinstance(rows, int | np.integer):
            rows = [rows]
        chosen = type(self)(**{name: getattr(self, name)[rows] for name in self.columns()})
        return chosen if self.naming is None else chosen.named(self.naming)

    @property
    def naming(self) -> Naming | None:
        """What the indices mean; None: the table is of no result."""
        found: Naming | None = vars(self).get("_naming")
        return found

    def named(self, naming: Naming) -> Self:
        """The same table, of a result."""
        made = copy.copy(self)
        object.__setattr__(made, "_naming", naming)
        return made

    @overload
    def to_dataframe(self, library: Literal["pandas"] = "pandas") -> pandas.DataFrame: ...
    @overload
    def to_dataframe(self, library: Literal["polars"]) -> polars.DataFrame: ...
    def to_dataframe(self, library: str = "pandas") -> Any:
        """The table as a data frame with as many rows.

        Columns carry their units (`position_x_m`, `impulse_z_Ns`); parts, items and people are
        categories by name, missing where the index is -1, and `time_s` is the time of the frame.

        Args:
            library: "pandas" or "polars".

        Raises:
            MissingDependencyError: It is not installed: pip install 'halfphysics[frames]'.
            InputError: Another library.
        """
        from halfphysics.results.frames import table_frame

        return table_frame(self, library)

    @classmethod
    def none(cls) -> Self:
        """A table without rows."""
        empty: dict[str, Any] = {
            name: np.zeros((0, 3) if name in cls.VECTORS else 0)
            if name in cls.VECTORS | cls.NUMBERS
            else np.zeros(0, dtype=np.int64)
            for name in cls.columns()
        }
        return cls(**empty)

    def check_within(self, limits: Mapping[str, tuple[int, int]]) -> None:
        """Refuse a column with a number outside its limits, low <= x < high."""
        for name in self.columns():
            values = getattr(self, name)
            if name not in limits or not len(values):
                continue
            low, high = limits[name]
            if not (values.min() >= low and values.max() < high):
                raise InputError(
                    f"{self.NAME}.{name}: found {values.min()} to {values.max()}, expected "
                    f"{low} to {high - 1}"
                )


def _whole(name: str, value: Any) -> Ints:
    array = as_array(value)
    if array.ndim != 1 or (array.size and array.dtype.kind not in "iu"):
        raise InputError(
            f"{name}: found shape {array.shape} of {array.dtype}, expected whole numbers (n,)"
        )
    result = array.astype(np.int64)
    result.setflags(write=False)
    return result
