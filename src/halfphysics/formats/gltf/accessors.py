"""Numbers of a glTF file: an accessor is rows of one type in a view of a buffer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import shown
from halfphysics.formats.gltf.container import Container, is_index

Array = NDArray[np.float64]

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def rows(container: Container, index: Any, kind: str, what: str) -> Array:
    """The rows (n, k) of an accessor as numbers.

    Integers that stand for fractions (`normalized`) are divided by their largest value, as the
    specification says. `sparse` accessors, which neither skins nor animations have, are refused.

    Args:
        container: The file.
        index: The accessor.
        kind: The expected type: "SCALAR", "VEC3", "VEC4" or "MAT4".
        what: What it is, for messages: "the times of channel 3".

    Raises:
        FileError: It is of another type, reaches beyond its buffer, or has NaN.
    """
    raw = stored(container, index, kind, what)
    entry = container.entry("accessors", index)
    array = raw.astype(np.float64)
    if entry.get("normalized") is True and raw.dtype.kind in "iu":
        array = np.maximum(array / np.iinfo(raw.dtype).max, -1.0)
    if not np.isfinite(array).all():
        row = int(np.argwhere(~np.isfinite(array))[0][0])
        raise container.error(f"{what}: NaN or infinite numbers, the first in row {row}")
    return array


def stored(container: Container, index: Any, kind: str, what: str) -> NDArray[Any]:
    """The rows (n, k) of an accessor, in the number type of the file."""
    entry = container.entry("accessors", index)
    number, found = entry.get("componentType"), entry.get("type")
    if found != kind or not isinstance(number, int) or number not in _TYPES:
        raise container.error(
            f"{what}: found accessor {index} of {shown(found)} and component type "
            f"{shown(number)}, expected {kind}"
        )
    if "sparse" in entry or "bufferView" not in entry:
        raise container.error(
            f"{what}: accessor {index} is sparse or has no data, which is not read. Export it plain"
        )
    view = container.entry("bufferViews", entry["bufferView"])
    data = container.buffer(view.get("buffer"))
    dtype, width = np.dtype(_TYPES[number]), _WIDTHS[kind]
    size = width * dtype.itemsize
    said: tuple[Any, ...] = (
        view.get("byteOffset", 0), view.get("byteLength"), view.get("byteStride", size),
        entry.get("byteOffset", 0), entry.get("count"),
    )  # fmt: skip
    wide = len(data) + 1
    whole = all(is_index(value, wide) for value in said)
    start, length, stride, offset, count = (int(v) for v in said) if whole else (0, 0, 0, 0, 0)
    fits = count > 0 and stride >= size and start + length < wide
    if not fits or offset + (count - 1) * stride + size > length:
        raise container.error(
            f"{what}: accessor {index} has {shown(said[4])} rows of {size} bytes from "
            f"{shown(said[3])} on, its view {shown(said[1])} bytes of a buffer of {len(data)}"
        )
    first = start + offset
    if stride == size:
        flat = data[first : first + count * size]
    else:
        step = np.lib.stride_tricks.as_strided(
            data[first:], shape=(count, size), strides=(stride, 1), writeable=False
        )
        flat = np.ascontiguousarray(step).reshape(-1)
    return np.frombuffer(np.ascontiguousarray(flat).tobytes(), dtype).reshape(count, width)
