"""Tar archives in pieces: members alone, and the end that makes them an archive.

Pieces in a row followed by the end are, byte for byte, what `tarfile` writes in one go (USTAR).
The bytes depend on names and content only: no dates, owners or rights of the machine.
"""

from __future__ import annotations

import tarfile

from halfphysics.errors import InputError


def member(name: str, data: bytes) -> tuple[bytes, bytes, bytes]:
    """A file of an archive as three pieces: its header, `data` itself, and what fills the block.

    Raises:
        InputError: The name does not fit a USTAR header (100 bytes), or the data (8 GiB).
    """
    info = tarfile.TarInfo(name)  # mode 0644, no date, nobody's
    info.size = len(data)
    try:
        header = info.tobuf(tarfile.USTAR_FORMAT, "utf-8", "strict")
    except ValueError as error:
        raise InputError(
            f"tar: {name!r} with {len(data)} bytes does not fit an archive ({error}); expected a "
            "name of up to 100 bytes and less than 8 GiB. Cut the clip into shorter ones"
        ) from None
    return header, data, bytes(-len(data) % tarfile.BLOCKSIZE)


def ending(size: int) -> bytes:
    """What closes an archive whose members take `size` bytes: two empty blocks, a full record."""
    empty = 2 * tarfile.BLOCKSIZE
    return bytes(empty + -(size + empty) % tarfile.RECORDSIZE)
