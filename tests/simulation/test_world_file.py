"""The bytes of world files: header, checksum, alignment."""

from __future__ import annotations

import struct
import zlib

import numpy as np

from halfphysics.simulation.call_recorder import Call
from halfphysics.simulation.world_file import MAGIC, VERSION, world_bytes


def test_the_layout():
    values = np.arange(6, dtype=np.float64).reshape(3, 2)
    data = world_bytes(
        [Call("name_it", {"text": "wörd", "rows": values, "one": np.array(7, np.int32)})]
    )
    assert data[:8] == MAGIC
    version, crc, size, calls, zero = struct.unpack_from("<IIQII", data, 8)
    assert (version, size, calls, zero) == (VERSION, len(data) - 32, 1, 0)
    assert crc == zlib.crc32(data[32:])
    assert struct.unpack_from("<II24s", data, 32) == (3, 0, b"name_it".ljust(24, b"\0"))
    at = 64
    assert struct.unpack_from("<24sII3Q", data, at)[1:] == (3, 1, 5, 1, 1)
    assert data[at + 56 : at + 64] == "wörd".encode() + bytes(3)
    at += 64
    assert struct.unpack_from("<24sII3Q", data, at)[1:] == (2, 2, 3, 2, 1)
    assert np.array_equal(np.frombuffer(data, "<f8", 6, at + 56).reshape(3, 2), values)
    at += 56 + 48
    assert struct.unpack_from("<24sII3Q", data, at)[1:] == (1, 0, 1, 1, 1)
    assert struct.unpack_from("<i", data, at + 56) == (7,)
    assert len(data) == at + 64
    assert len(data) % 8 == 0
