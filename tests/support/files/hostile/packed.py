"""Compressed files that unpack to gigabytes."""

from __future__ import annotations

import bz2
import lzma
import zlib
from pathlib import Path

from support.files.hostile.attacks import attack, written


def _gzip() -> bytes:
    """3 GiB of zeros behind the start of a pickle: full blocks of deflate repeat."""
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    head = packer.compress(b"\x80\x04B\x00\x00\x00\xc0") + packer.flush(zlib.Z_FULL_FLUSH)
    one = packer.compress(bytes(2**24)) + packer.flush(zlib.Z_FULL_FLUSH)
    return head + one * 192


@attack("motion")
def gzip_of_3_gigabytes(folder: Path) -> Path:
    return written(folder / "a.pkl", _gzip())


@attack("motion")
def bz2_of_zeros(folder: Path) -> Path:
    packer = bz2.BZ2Compressor()
    return written(folder / "a.pkl", packer.compress(bytes(160 * 2**20)) + packer.flush())


@attack("motion")
def xz_of_zeros(folder: Path) -> Path:
    packer = lzma.LZMACompressor(preset=0)
    content = packer.compress(bytes(160 * 2**20)) + packer.flush()
    return written(folder / "a.pkl", content)


@attack("motion")
def lzma_with_a_dictionary_of_4_gigabytes(folder: Path) -> Path:
    content = bytearray(lzma.compress(bytes(100), lzma.FORMAT_ALONE))
    content[1:5] = b"\xff\xff\xff\xff"
    content[0:3] = b"]\x00\x00"
    content[3:5] = b"\x00\xf0"
    return written(folder / "a.pkl", bytes(content))
