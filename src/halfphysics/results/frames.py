"""Tables of a result as data frames of pandas or polars: one row per row, names as categories.

Columns carry their unit: `position_x_m`, `impulse_z_Ns`. What was an index of a name is a category
of all names there are; what was -1 is missing. Frames of pandas have the units in
`frame.attrs["units"]`, too.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.optional_package import optional
from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.results.naming import JOINT_COLUMNS, NAME_COLUMNS, Naming

if TYPE_CHECKING:
    from halfphysics.results.table import Table

#: Endings of columns' names for units that names cannot hold.
_ENDINGS = {"N s": "Ns"}


def table_frame(table: Table, library: str) -> Any:
    """The work behind `Table.to_dataframe`."""
    makers = {"pandas": _pandas, "polars": _polars}
    if not isinstance(library, str) or library not in makers:
        raise InputError(f"library: found {shown(library)}, expected 'pandas' or 'polars'")
    module = optional(library, "data frames", "frames")
    return makers[library](module, list(_columns(table)), table.UNITS)


Column = tuple[str, NDArray[Any], tuple[str, ...] | None]


def _columns(table: Table) -> Iterator[Column]:
    """Names, values and categories (None: numbers) of the columns."""
    naming: Naming | None = table.naming
    for name in sorted(table.columns(), key=lambda name: name != "frame"):
        values = getattr(table, name)
        unit = table.UNITS.get(name, "")
        ending = f"_{_ENDINGS.get(unit, unit)}" if unit else ""
        if name in table.VECTORS:
            for axis, letter in enumerate("xyz"):
                yield f"{name}_{letter}{ending}", values[:, axis], None
        elif name in JOINT_COLUMNS:
            yield name, values, JOINT_NAMES
        elif naming is not None and name in NAME_COLUMNS:
            yield name, values, naming.names
        elif naming is not None and name == "person":
            yield name, values, naming.persons
        else:
            yield f"{name}{ending}", values, None
        if name == "frame" and naming is not None:
            yield "time_s", values / naming.fps, None


def _pandas(pandas: Any, columns: list[Column], units: Any) -> Any:
    made = {
        name: values if known is None else pandas.Categorical.from_codes(values, list(known))
        for name, values, known in columns
    }
    frame = pandas.DataFrame(made)
    frame.attrs["units"] = {
        name: unit
        for name in frame.columns
        for column, unit in {"time": "s", **units}.items()
        if name == column or name.startswith(f"{column}_")
    }
    return frame


def _polars(polars: Any, columns: list[Column], _: Any) -> Any:
    made = []
    for name, values, known in columns:
        if known is None:
            made.append(polars.Series(name, values.copy()))
            continue
        # An index of -1 is the last entry: missing.
        words = np.array([*known, None], dtype=object)[values].tolist()
        made.append(polars.Series(name, words, dtype=polars.Enum(list(known))))
    return polars.DataFrame(made)
