"""Objects that Python programs stored: pickles and formats built on them.

Plain pickles, joblib dumps (compressed or not), `.npy` files of objects and files of `torch.save`:
all go through `restricted_pickle`. Data comes out and nothing is run.
"""

from __future__ import annotations

import bz2
import io
import lzma
import pickle
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np

from halfphysics.base import restricted_pickle, torch_file
from halfphysics.base.atomic import atomic_write
from halfphysics.base.npy import Npy
from halfphysics.base.pickle_budget import FREE_BYTES
from halfphysics.base.pickle_placeholders import MAX_BYTES
from halfphysics.errors import FileError

#: Pickles of protocol 2 and later begin so; earlier ones are recognised by the file's name.
_PROTOCOL = b"\x80"
_SUFFIXES = (".pkl", ".pickle", ".p", ".joblib", ".pt", ".pth")
#: How protocol 3 names a function of numpy's core, in numpy 2 and in all.
_NEW_NAME, _OLD_NAME = b"cnumpy._core.multiarray\n", b"cnumpy.core.multiarray\n"
_ZIP, _NPY, _LZ4 = b"PK", b"\x93NUMPY", b"\x04\x22M\x18"
#: The first bytes of a BVH file, and those that may precede them.
_BVH, _BLANK = b"HIERARCHY", b"\xef\xbb\xbf \t\r\n"
#: Bytes that tell how a file is compressed; bytes that are unpacked and read at a time.
_HEAD, _CHUNK, _SLICE = 6, 2**20, 2**16
#: Dumps of motions compress to a fifth at best.
_RATIO = 50


def is_stored(path: Path, head: bytes) -> bool:
    """Whether a file that begins with `head` is a stored object."""
    if head.startswith(_ZIP):
        return torch_file.is_torch(path)
    if head.startswith(_NPY):
        return Npy(path).dtype.hasobject
    if head.startswith(_PROTOCOL):
        return True
    return path.suffix.lower() in _SUFFIXES and not head.lstrip(_BLANK).startswith(_BVH)


def read(path: Path) -> Any:
    """The objects stored in a file: numbers, strings, numpy arrays and containers.

    Raises:
        FileError: Anything else is in it, it is damaged, or unpacks to more than `MAX_BYTES`.
    """
    try:
        with path.open("rb") as handle:
            head = handle.read(len(_NPY))
            if head.startswith(_ZIP):
                return torch_file.read(path)
            handle.seek(Npy(path).offset if head == _NPY else 0)
            size = path.stat().st_size
            if size > MAX_BYTES:
                raise _too_large(path, size)
            data = _unpacked(path, handle, size)
    except OSError as error:
        raise FileError(f"{path}: cannot read: {error.strerror}") from None
    content = restricted_pickle.loads(data, path, torch_file.INLINE, on_disk=size)
    if head == _NPY and getattr(content, "size", 0) == 1:
        return content.item()  # numpy.save of a dict
    if isinstance(content, int) and content == torch_file.OLD_MAGIC:
        return torch_file.read_old(data, str(path))
    return content


def _unpacked(path: Path, handle: IO[bytes], size: int) -> bytes:
    """The rest of a file of `size` bytes, decompressed where it is compressed as joblib does it."""
    head = handle.peek(_HEAD)[:_HEAD] if isinstance(handle, io.BufferedReader) else b""
    unpacker = _unpacker(path, head)
    if unpacker is None:
        return handle.read()
    pieces: list[bytes] = []
    total, packed, most = 0, b"", max(FREE_BYTES, _RATIO * size)
    try:
        while not unpacker.eof:
            if not packed and getattr(unpacker, "needs_input", True):
                packed = handle.read(_SLICE)
            piece = unpacker.decompress(packed, _CHUNK)
            if not packed and not piece:
                raise EOFError("it ends in the middle")
            packed = getattr(unpacker, "unconsumed_tail", b"")
            total += len(piece)
            if total > MAX_BYTES:
                raise _too_large(path, total)
            if total > most:
                raise FileError(
                    f"{path}: unpacks from {size / 2**20:.1f} MiB to {most / 2**20:.0f} MiB and "
                    f"more, expected at most {_RATIO} times its size. If it is what it should "
                    "be, unpack it first"
                )
            pieces.append(piece)
    except (zlib.error, lzma.LZMAError, OSError, ValueError, EOFError, MemoryError) as error:
        raise FileError(
            f"{path}: damaged or truncated ({error}). Download or copy the file again"
        ) from None
    return b"".join(pieces)


def _unpacker(path: Path, head: bytes) -> Any:
    """What decompresses a file that begins so; None: it is not compressed."""
    if head[:2] == b"\x1f\x8b" or head[:1] == b"\x78":
        return zlib.decompressobj(wbits=47)  # zlib or gzip
    if head[:3] == b"BZh":
        return bz2.BZ2Decompressor()
    if head[:6] == b"\xfd7zXZ\x00" or head[:3] == b"]\x00\x00":
        return lzma.LZMADecompressor(memlimit=FREE_BYTES)
    if head[:4] == _LZ4:
        raise FileError(
            f"{path}: compressed with lz4, which is not read. Save it again with "
            "joblib.dump(..., compress=3)"
        )
    return None


def _too_large(path: Path, size: int) -> FileError:
    return FileError(
        f"{path}: {size / 2**30:.1f} GiB, expected at most {MAX_BYTES / 2**30:.0f} GiB in one "
        "stored object"
    )


def write(path: Path, data: Any) -> None:
    """Pickle arrays, numbers, strings and containers of them.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    with atomic_write(path) as handle:
        handle.write(dumps(data))


def write_object_array(handle: IO[bytes], data: Any) -> None:
    """Write what `numpy.save` writes of an object: an array of no dimensions around it."""
    array = np.asarray(data, dtype=object)
    header = {"descr": "|O", "fortran_order": False, "shape": array.shape}
    np.lib.format.write_array_header_1_0(handle, header)
    handle.write(dumps(array))


def dumps(data: Any) -> bytes:
    """A pickle that every numpy reads: numpy 2 names its module so that older ones have none."""
    return pickle.dumps(data, protocol=3).replace(_NEW_NAME, _OLD_NAME)
