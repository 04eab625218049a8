"""Tar archives in pieces: single members, the end of an archive, and reading samples.

Consecutive members followed by the end are, byte for byte, the USTAR archive that `tarfile` writes.
The bytes depend on names and content only: no dates, owners or permissions of the machine.
"""

from __future__ import annotations

import tarfile
from collections.abc import Callable, Iterator
from pathlib import Path

from halfphysics.errors import InputError


def member(name: str, data: bytes) -> tuple[bytes, bytes, bytes]:
    """A file of an archive as three pieces: its header, `data` itself, and the padding.

    Raises:
        InputError: The name (100 bytes) or the data (8 GiB) does not fit a USTAR header.
    """
    info = tarfile.TarInfo(name)  # mode 0644, no date, no owner
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
    """The end of an archive with `size` bytes of members: two empty blocks, padded to a record."""
    empty = 2 * tarfile.BLOCKSIZE
    return bytes(empty + -(size + empty) % tarfile.RECORDSIZE)


def samples(
    path: Path, wanted: Callable[[str], bool] | None = None
) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Key and files (name -> content) of each sample of a shard, one at a time.

    Args:
        path: The shard.
        wanted: Selects the files to read by name; None: all.

    Raises one of `contents.DAMAGE` if the file is not a shard, or incomplete.
    """
    key, files, end = "", dict[str, bytes](), 0
    with tarfile.open(path, "r|") as archive:
        for member in archive:
            end = member.offset_data + member.size
            own, _, name = member.name.partition(".")
            handle = archive.extractfile(member) if member.isreg() and own and name else None
            if handle is None:
                raise ValueError(f"found {member.name!r} in it, expected NUMBER.human.npz")
            if key and own != key:
                yield key, files
                files = {}
            key = own
            if wanted is None or wanted(name):
                files[name] = handle.read()
    _check_end(path, end)
    if key:
        yield key, files


def _check_end(path: Path, end: int) -> None:
    """Raise if a tar has no valid end: `tarfile` takes damage for the end."""
    with path.open("rb") as handle:
        handle.seek(end)
        rest = handle.read(2 * tarfile.RECORDSIZE)
    if len(rest) < 2 * tarfile.BLOCKSIZE or rest.strip(b"\0"):
        raise ValueError(f"no end of an archive after {end} bytes")
