"""Safe reading and whole writing of `.npz` files: no pickles, no bombs, no half files."""

from __future__ import annotations

import io
import lzma
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Any, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.atomic import atomic_write
from halfphysics.base.npy import read_header
from halfphysics.errors import FileError

# A day of full-body motion at 120 fps is about 10 GB; anything a session uses is far below.
MAX_BYTES = 8 * 2**30
# A result of a thousand objects has 5,000.
MAX_MEMBERS = 16_384
# Motions compress to about a fifth. Only files made to fill the memory compress by more than this;
# smaller ones may be all zeros.
MAX_RATIO, SUSPICIOUS_BYTES = 200, 2**28
#: The head of a member: mark, version, flags, 16 bytes that the directory has too, the lengths of
#: the name and of more that follow.
_LOCAL = struct.Struct("<4s2xH18xHH")
#: How reading a damaged archive can fail.
DAMAGE = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError, NotImplementedError,
    RuntimeError, ValueError, OSError,
)  # fmt: skip


class Npz(Mapping[str, NDArray[Any]]):
    """The arrays of an `.npz` file, each read on access.

    Args:
        path: The file, or the name in messages of `data`.
        data: The bytes of an archive within another file; None: those of the file.

    Raises:
        FileError: The file is not a readable archive, is truncated, is absurdly large, or an
            array in it is damaged or holds Python objects (those are pickles: never read).
    """

    def __init__(self, path: str | os.PathLike[str], data: bytes | None = None) -> None:
        self.path = Path(path)
        self._data = data
        self._members: dict[str, zipfile.ZipInfo] = {}
        try:
            size = self.path.stat().st_size if data is None else len(data)
            with zipfile.ZipFile(self._file()) as archive:
                infos = archive.infolist()
        except DAMAGE as error:
            raise FileError(
                f"{self.path}: damaged or truncated .npz archive ({error}). Download or copy the "
                "file again"
            ) from None
        total = sum(info.file_size for info in infos)
        if total > MAX_BYTES or len(infos) > MAX_MEMBERS:
            raise FileError(
                f"{self.path}: unpacks to {total / 2**30:.1f} GiB in {len(infos)} arrays, expected "
                f"at most {MAX_BYTES / 2**30:.0f} GiB in {MAX_MEMBERS}. Split the file"
            )
        # Members may share their bytes: the file is as long as it is.
        packed = min(size, sum(info.compress_size for info in infos))
        if total > max(SUSPICIOUS_BYTES, MAX_RATIO * packed):
            raise FileError(
                f"{self.path}: unpacks from {packed / 2**20:.1f} MiB to {total / 2**30:.1f} GiB, "
                f"expected at most {MAX_RATIO} times its size. If it is what it should be, save it "
                "uncompressed (numpy.savez)"
            )
        for info in infos:
            # Names of control characters are no data set's, and would end up in messages.
            if info.filename.endswith(".npy") and info.filename.isprintable():
                self._members[info.filename.removesuffix(".npy")] = info

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)

    def __contains__(self, key: object) -> bool:
        return key in self._members

    def describe(self) -> str:
        """The keys with their shapes, for messages."""
        parts = []
        for key in list(self)[:24]:
            shape, dtype = self.header(key)
            parts.append(f"{key} {shape}" if not dtype.hasobject else f"{key} (Python object)")
        return ", ".join(parts) + (", ..." if len(self) > 24 else "")

    def header(self, key: str) -> tuple[tuple[int, ...], np.dtype[Any]]:
        """Shape and type of an array without reading it."""
        with self._open(key) as stream:
            shape, _, dtype = self._read_header(key, stream)
        return shape, dtype

    def __getitem__(self, key: str) -> NDArray[Any]:
        if key not in self._members:
            raise KeyError(key)
        try:
            with self._open(key) as stream:
                shape, fortran, dtype = self._read_header(key, stream)
                if dtype.hasobject:
                    raise FileError(
                        f"{self.path}: field '{key}' holds Python objects (a pickle), which are "
                        "not read from untrusted files. Save it as a plain array or a string"
                    )
                count = math.prod(shape)
                size = self._members[key].file_size - stream.tell()
                if size != count * dtype.itemsize:  # before anything is unpacked
                    raise self._damaged(
                        key,
                        f"{size} bytes for shape {shape} of {dtype}, which needs "
                        f"{count * dtype.itemsize}",
                    )
                data = stream.read()
        except DAMAGE as error:
            raise self._damaged(key, str(error)) from None
        if len(data) != size:
            raise self._damaged(key, f"{len(data)} bytes of {size}")
        array = np.frombuffer(data, dtype=dtype, count=count)
        return array.reshape(shape, order="F" if fortran else "C")

    def _damaged(self, key: str, reason: str) -> FileError:
        return FileError(
            f"{self.path}: field '{key}' is damaged or truncated ({reason}). Download or copy the "
            "file again"
        )

    def _file(self) -> Path | io.BytesIO:
        return self.path if self._data is None else io.BytesIO(self._data)

    def _open(self, key: str) -> IO[bytes]:
        """The unpacked bytes of a member; the directory of the archive is not read again."""
        info = self._members[key]
        try:
            handle = self.path.open("rb") if self._data is None else io.BytesIO(self._data)
            try:
                handle.seek(info.header_offset)
                head = handle.read(_LOCAL.size)
                mark, flags, name, extra = _LOCAL.unpack(head)
                if mark != b"PK\x03\x04" or flags & 1:
                    raise zipfile.BadZipFile("encrypted" if flags & 1 else "no member there")
                handle.seek(name + extra, os.SEEK_CUR)
                member: Any = zipfile.ZipExtFile(handle, "r", info, close_fileobj=True)
            except BaseException:
                handle.close()
                raise
            return cast("IO[bytes]", member)
        except DAMAGE as error:
            raise self._damaged(key, str(error)) from None

    def _read_header(
        self, key: str, stream: IO[bytes]
    ) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
        try:
            return read_header(stream)
        except DAMAGE as error:
            raise self._damaged(key, str(error)) from None


def write_npz(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as a compressed `.npz`: the same arrays give the same bytes.

    Raises:
        FileError: The folder is missing or cannot be written; nothing is left behind.
    """
    with atomic_write(path) as handle:
        pack_npz(handle, arrays)


def pack_npz(handle: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    """`write_npz` into an open file."""
    with zipfile.ZipFile(handle, "w") as archive:
        for key, array in arrays.items():
            info = _entry(key)
            with archive.open(info, "w", force_zip64=True) as stream:
                np.lib.format.write_array(stream, np.asanyarray(array), allow_pickle=False)


def _entry(key: str) -> zipfile.ZipInfo:
    """Of an array, with a fixed date, so that the bytes depend on the content only."""
    info = zipfile.ZipInfo(f"{key}.npy", date_time=(1980, 1, 1, 0, 0, 0))
    info.compress_type = zipfile.ZIP_DEFLATED
    info.external_attr = 0o644 << 16
    return info
