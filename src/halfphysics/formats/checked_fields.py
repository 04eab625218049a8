"""Named fields of a file, checked when they are read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.arrays import as_array
from halfphysics.base.validation import shown
from halfphysics.errors import FileError

Array = NDArray[np.float64]

_ALL = slice(None)
#: Rows whose shapes are looked at for a message.
_ROWS = 10_000


def shape_of(value: Any) -> tuple[int, ...] | None:
    """The shape of an array, or of lists; None: these have rows of different lengths."""
    try:
        return as_array(value).shape
    except (TypeError, ValueError, MemoryError):
        return None


def _no_array(value: Any) -> str:
    """What is no array, in a line for messages."""
    rows = value[:_ROWS] if isinstance(value, list | tuple) else []
    shapes = list(dict.fromkeys(str(shape_of(row)) for row in rows))
    if len(shapes) > 1:
        return f"rows of shapes {shapes[0]} and {shapes[1]}"
    return " ".join(shown(value).split())


class Record:
    """The fields of a file, or of one clip or part of it, from any kind of container.

    Args:
        where: Name in messages: the file, and its clip or part if it has several.
        fields: Name -> array, number or text.

    Raises:
        FileError: All methods raise it for a missing or impossible field. The message names the
            file, the field, the value found, the value expected and a remedy.
    """

    def __init__(self, where: str | Path, fields: Mapping[str, Any]) -> None:
        self.where = str(where)
        self.fields = fields

    def __contains__(self, key: object) -> bool:
        return key in self.fields

    def describe(self) -> str:
        """The fields with their shapes, for messages."""
        describe = getattr(self.fields, "describe", None)
        if describe is not None:
            return str(describe()) or "no fields"
        parts = []
        for key in list(self.fields)[:24]:
            shape = getattr(self.fields[key], "shape", None)
            parts.append(f"{key} {tuple(shape)}" if shape is not None else str(key))
        more = ", ..." if len(self.fields) > 24 else ""
        return (", ".join(parts) or "no fields") + more

    def error(self, key: str, text: str) -> FileError:
        """An error about a field."""
        return FileError(f"{self.where}: field '{key}': {text}")

    def raw(self, key: str, wanted: str = "") -> Any:
        """A field, unchecked; `wanted` describes it in the message if it is missing."""
        if key not in self.fields:
            near = [k for k in self.fields if isinstance(k, str) and key.lower() in k.lower()]
            hint = f"; is it '{near[0]}'? Rename it" if near else ""
            expected = f"; expected {key} {wanted}".rstrip()
            raise FileError(
                f"{self.where}: field '{key}' is missing, found {self.describe()}{expected}{hint}"
            )
        return self.fields[key]

    def shape(self, key: str, wanted: str = "") -> tuple[int, ...]:
        """The shape of a field of anything; `wanted` as of `raw`."""
        header = getattr(self.fields, "header", None)
        if header is not None and key in self.fields:
            found, dtype = header(key)
            if not dtype.hasobject:
                return tuple(found)
        return self._as_array(key, wanted).shape

    def flat(self, key: str, wanted: str = "") -> NDArray[Any]:
        """The values of a field of anything, in one row; `wanted` as of `raw`."""
        return self._as_array(key, wanted).reshape(-1)

    def _as_array(self, key: str, wanted: str) -> NDArray[Any]:
        value = self.raw(key, wanted)
        try:
            return as_array(value)
        except (TypeError, ValueError, MemoryError):
            expected = f"an array {wanted}".rstrip()
            raise self.error(key, f"found {_no_array(value)}, expected {expected}") from None

    def array(self, key: str, *shape: int | None, frames: slice = _ALL) -> Array:
        """A field as finite float64 numbers of `shape` (None: T), cut to `frames`."""
        return np.array(self.numbers(key, *shape, frames=frames), dtype=np.float64)

    def numbers(self, key: str, *shape: int | None, frames: slice = _ALL) -> NDArray[Any]:
        """Like `array`, in the number type of the file."""
        wanted = "(" + ", ".join("T" if n is None else str(n) for n in shape)
        wanted += ",)" if len(shape) == 1 else ")"
        header = getattr(self.fields, "header", None)
        if header is not None and key in self.fields:
            found, dtype = header(key)
            if not dtype.hasobject:  # else its shape is known once it is read
                self._check(key, found, dtype, shape, wanted)
        value = self.raw(key, wanted)
        try:
            array = as_array(value)
        except (TypeError, ValueError, MemoryError):
            raise self.error(key, f"found {_no_array(value)}, expected numbers {wanted}") from None
        self._check(key, array.shape, array.dtype, shape, wanted)
        if shape and shape[0] is None:
            array = array[frames]
        bad = ~np.isfinite(array)
        if bad.any():
            row = int(np.argwhere(bad)[0][0]) if array.ndim else 0
            raise self.error(
                key,
                f"{int(bad.sum())} values are NaN or infinite, the first in frame {row}; expected "
                "finite numbers. Fill those frames, or read others with frames=(start, stop)",
            )
        return array

    def _check(
        self,
        key: str,
        found: tuple[int, ...],
        dtype: np.dtype[Any],
        shape: tuple[int | None, ...],
        wanted: str,
    ) -> None:
        fits = len(found) == len(shape) and all(
            n is None or n == m for n, m in zip(shape, found, strict=True)
        )
        if not fits or dtype.kind not in "fiu":
            raise self.error(key, f"found shape {found} of {dtype}, expected numbers of {wanted}")

    def number(self, key: str, *, above: float = -np.inf, below: float = np.inf) -> float:
        """A field as one number: an array of any shape with one element."""
        array = self._as_array(key, "(one number)")
        one = array.size == 1 and array.dtype.kind in "fiu"
        if not one or not above < float(array.reshape(-1)[0]) < below:
            range = f" between {above:g} and {below:g}" if np.isfinite([above, below]).any() else ""
            raise self.error(key, f"found {shown(array.tolist())}, expected a number{range}")
        return float(array.reshape(-1)[0])

    def text(self, key: str) -> str:
        """A field as text, stored as str, bytes or an array of one of them."""
        value = self._as_array(key, "(text)")
        item = value.reshape(-1)[0] if value.size == 1 else None
        if isinstance(item, bytes):
            item = item.decode("utf-8", "replace")
        if not isinstance(item, str):
            raise self.error(key, f"found {shown(value.tolist())}, expected text")
        # Many files hold the str() of bytes.
        return item.strip().removeprefix("b'").removesuffix("'")
