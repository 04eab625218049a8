"""World files: recorded calls as bytes (src/native/compiled/world_file.h has the layout)."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.simulation.call_recorder import Call

MAGIC = b"\x89HPW\r\n\x1a\n"
#: Of the layout; what reads it takes this one only.
VERSION = 1
_INT, _DOUBLE, _TEXT = 1, 2, 3


def world_bytes(calls: Sequence[Call]) -> bytes:
    """The bytes of a world file with these calls."""
    body = b"".join(map(_call, calls))
    return MAGIC + struct.pack("<IIQII", VERSION, zlib.crc32(body), len(body), len(calls), 0) + body


def _call(call: Call) -> bytes:
    head = struct.pack("<II24s", len(call.arguments), 0, call.name.encode())
    return head + b"".join(_argument(name, value) for name, value in call.arguments.items())


def _argument(name: str, value: NDArray[Any] | str) -> bytes:
    if isinstance(value, str):
        kind, data = _TEXT, value.encode()
        shape: tuple[int, ...] = (len(data),)
    else:
        kind, shape = (_INT if value.dtype == np.int32 else _DOUBLE), value.shape
        data = value.astype(value.dtype.newbyteorder("<"), copy=False).tobytes()
    lengths = (*shape, 1, 1, 1)[:3]
    head = struct.pack("<24sII3Q", name.encode(), kind, len(shape), *lengths)
    return head + data + bytes(-len(data) % 8)
