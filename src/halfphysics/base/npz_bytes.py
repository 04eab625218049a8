"""A fast writer of `.npz` archives in memory, for many small files that are mostly zeros.

The bytes depend on the arrays only. An array that hardly compresses is stored without compression
(a motion: compression takes 60 times as long as storing and saves a fourteenth). Other arrays are
compressed in blocks; the result for a block of zeros (contact labels) is known beforehand, and that
for a whole array is kept for the next file (a mesh).
"""

from __future__ import annotations

import io
import struct
import zlib
from collections import OrderedDict
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError

# An array with a larger share of numbers other than zero may not compress well.
_DENSE = 0.75
_BLOCK = 1 << 16
# Of a dense array this many bytes of its middle are compressed as a test: it is compressed as a
# whole if they shrink to the share `_WORTH`.
_PROBE, _WORTH = 4096, 0.6
# Size of the cache of compressed arrays [bytes].
_REMEMBERED = 16 * 2**20
_LARGEST = 2**32 - 1
_STORED, _DEFLATED = 0, 8
# 1980-01-01 in DOS format, the earliest date of a zip archive.
_DATE = 0x21

_before: OrderedDict[bytes, bytes] = OrderedDict()


def npz_bytes(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """The archive as `numpy.load` reads it.

    Raises:
        InputError: It is larger than 4 GiB.
        ValueError: An array holds Python objects.
    """
    pieces: list[bytes | memoryview] = []
    heads: list[bytes] = []
    offset = 0
    for key, given in arrays.items():
        name = f"{key}.npy".encode()
        array = np.asanyarray(given)
        header, content = _npy(array)
        packed = _packed(array, header, content)
        data = [header, content] if packed is None else packed
        crc = _crc(content, zlib.crc32(header))
        whole, size = len(header) + len(content), sum(map(len, data))
        # A flag marks names with letters beyond ASCII as UTF-8.
        flags = 0 if name.isascii() else 0x800
        method = _STORED if packed is None else _DEFLATED
        if max(whole, size, offset) > _LARGEST:
            raise _too_large(key, whole)
        same = struct.pack("<5H3L2H", 20, flags, method, 0, _DATE, crc, size, whole, len(name), 0)
        pieces += [b"PK\x03\x04", same, name, *data]
        attributes = struct.pack("<3H2L", 0, 0, 0, 0o100644 << 16, offset)
        heads += [b"PK\x01\x02", struct.pack("<H", 0x314), same, attributes, name]
        offset += 4 + len(same) + len(name) + size
    directory = b"".join(heads)
    count = len(arrays)
    if max(offset, len(directory)) > _LARGEST:
        raise _too_large(key, whole)
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, count, count, len(directory), offset, 0)
    return b"".join([*pieces, directory, end])


def _too_large(key: str, size: int) -> InputError:
    return InputError(
        f"{key}: {size} bytes of it do not fit a file of 4 GiB. Cut the clip into shorter ones"
    )


def packs(array: NDArray[Any]) -> bool:
    """Whether an array compresses well enough to be worth the time."""
    if array.dtype.kind not in "biuf" or array.size == 0:
        return False
    if _mostly_zeros(array):
        return True
    count = _PROBE // array.itemsize
    middle = array.reshape(-1)[array.size // 2 :][:count].tobytes()
    return len(zlib.compress(middle, 1)) <= _WORTH * len(middle)


def _mostly_zeros(array: NDArray[Any]) -> bool:
    return bool(np.count_nonzero(array) <= _DENSE * array.size)


def _packed(array: NDArray[Any], header: bytes, content: memoryview) -> list[bytes] | None:
    """The array's bytes, compressed; None where compression is not worth its time."""
    if not packs(array):
        return None
    if _mostly_zeros(array):
        return _deflated(header, content)
    raw = header + content
    known = _before.pop(raw, None) or b"".join(_deflated(header, content))
    _before[raw] = known
    while sum(map(len, _before)) > _REMEMBERED:
        _before.popitem(last=False)
    return [known]


def _npy(array: NDArray[Any]) -> tuple[bytes, memoryview]:
    """The bytes that `numpy.save` writes: the header and the numbers."""
    if array.dtype.hasobject or not array.flags.c_contiguous:
        whole = io.BytesIO()
        np.lib.format.write_array(whole, array, allow_pickle=False)
        return whole.getvalue(), memoryview(b"")
    return _header(array.dtype.str, array.shape), array.reshape(-1).view(np.uint8).data


@lru_cache(maxsize=256)
def _header(kind: str, shape: tuple[int, ...]) -> bytes:
    header = io.BytesIO()
    described = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(header, described)
    return header.getvalue()


def _deflated(header: bytes, content: memoryview) -> list[bytes]:
    """A deflate stream of blocks that are compressed independently."""
    pieces = [_flushed_header(header)]
    for at in range(0, len(content), _BLOCK):
        block = content[at : at + _BLOCK]
        pieces.append(_PACKED_ZEROS if _is_zeros(block) else _flushed(block))
    return [*pieces, b"\x03\x00"]  # an empty last block


def _crc(content: memoryview, start: int) -> int:
    """`zlib.crc32`, with a table for the effect of a block of zeros."""
    if len(content) < _BLOCK:
        return zlib.crc32(content, start)
    for at in range(0, len(content), _BLOCK):
        block = content[at : at + _BLOCK]
        start = _after_zeros(start) if _is_zeros(block) else zlib.crc32(block, start)
    return start


def _is_zeros(block: memoryview) -> bool:
    """Whether the block is of full size and all zeros."""
    return len(block) == _BLOCK and not np.frombuffer(block, np.uint64).any()


def _after_zeros(crc: int) -> int:
    """The checksum of data with checksum `crc` and a block of zeros after it."""
    first, second, third, fourth = _tables()
    return first[crc & 255] ^ second[crc >> 8 & 255] ^ third[crc >> 16 & 255] ^ fourth[crc >> 24]


@lru_cache(maxsize=1)
def _tables() -> list[list[int]]:
    """The effect of a block of zeros on each byte of a checksum: an affine map over bits."""
    zeros = bytes(_BLOCK)
    nothing = zlib.crc32(zeros)
    tables = []
    for byte in range(4):
        table = [0]
        for bit in range(8):
            change = zlib.crc32(zeros, 1 << (8 * byte + bit)) ^ nothing
            table += [known ^ change for known in table]
        tables.append(table)
    tables[0] = [known ^ nothing for known in tables[0]]
    return tables


def _flushed(block: bytes | memoryview) -> bytes:
    packer = zlib.compressobj(1, zlib.DEFLATED, -zlib.MAX_WBITS)
    return packer.compress(block) + packer.flush(zlib.Z_FULL_FLUSH)


_flushed_header = lru_cache(maxsize=256)(_flushed)
_PACKED_ZEROS = _flushed(bytes(_BLOCK))
