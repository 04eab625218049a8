"""The binary half of a glTF file: arrays in one buffer, and the JSON of their places."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Kinds of views: vertex attributes, and indices.
VERTICES, INDICES = 34962, 34963

_COMPONENTS = {"<f4": 5126, "|u1": 5121, "<u2": 5123, "<u4": 5125}
_SHAPES = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4", (16,): "MAT4"}


class Buffer:
    """Grows by `add`; `data`, `views` and `accessors` are the content of the file."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, array: NDArray[Any], target: int | None = None, *, bounds: bool = False) -> int:
        """Add an array (n,) or (n, k) in its own view; returns its accessor.

        Args:
            array: float32 or unsigned integers; little endian in the file.
            target: `VERTICES`, `INDICES`, or None for other data.
            bounds: Write its smallest and largest entries per column.
        """
        return self.add_all([array], target, bounds=bounds)[0]

    def add_all(
        self, arrays: list[NDArray[Any]], target: int | None = None, *, bounds: bool = False
    ) -> list[int]:
        """Add arrays that share one view; returns their accessors."""
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        first = len(self.accessors)
        for array in arrays:
            little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
            self.data += b"\0" * (-len(self.data) % 4)
            accessor: dict[str, Any] = {
                "bufferView": len(self.views),
                "componentType": _COMPONENTS[little.dtype.str],
                "count": len(little),
                "type": _SHAPES[little.shape[1:]],
            }
            if len(self.data) > start:
                accessor["byteOffset"] = len(self.data) - start
            if bounds:  # of the numbers as stored in the file
                rows = little.reshape(len(little), -1)
                accessor["min"] = rows.min(axis=0).tolist()
                accessor["max"] = rows.max(axis=0).tolist()
            self.accessors.append(accessor)
            self.data += little.tobytes()
        view = {"buffer": 0, "byteLength": len(self.data) - start}
        if start:
            view["byteOffset"] = start
        if target is not None:
            view["target"] = target
        self.views.append(view)
        return list(range(first, len(self.accessors)))
