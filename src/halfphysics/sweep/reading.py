"""Reading what a sweep made: samples one at a time, from a folder, a tar or an HDF5 file.

for sample in halfphysics.sweep.read("out"):
    sample["card"]["factors"], sample["human"]["poses"], sample["contact"]["body"]
"""

from __future__ import annotations

import io
import json
import os
import tarfile
import zipfile
import zlib
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from halfphysics.errors import FileError, InputError
from halfphysics.validation import file_path

#: How reading a damaged shard can fail.
_DAMAGE = (
    tarfile.TarError,
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    ValueError,
    KeyError,
    OSError,
)


def read(
    path: str | os.PathLike[str], parts: Collection[str] | None = None
) -> Iterator[dict[str, Any]]:
    """Samples in the order of their numbers, each read when it is asked for.

    Args:
        path: A folder that a sweep wrote (also while it is being written: what is sealed), or one
            of its shards, .tar or .h5.
        parts: Which files of a sample to look into, such as ("human", "card"); None: all.

    Yields:
        A dict: "key" its number as text, "card" what it was made from, and for each file its
        arrays by name: "human", "object", "contact", "human.1" (a second person), "result".

    Raises:
        FileError: Missing, damaged, or not what a sweep writes. Nothing is unpickled.
        InputError: `parts` is not a collection of names.
    """
    path = file_path(path)
    if isinstance(parts, str):
        raise InputError(f"parts: found {parts!r}, expected several names, such as ({parts!r},)")
    if path.is_dir():
        return _of_folder(path, parts)
    if not path.is_file():
        raise FileError(f"{path}: no such file, expected a folder of a sweep, a .tar or a .h5")
    if path.suffix == ".h5":
        from halfphysics.sweep.hdf5 import samples

        return samples(path, parts)
    return _of_tar(path, parts)


def _of_folder(folder: Path, parts: Collection[str] | None) -> Iterator[dict[str, Any]]:
    root = folder / "shards" if (folder / "shards").is_dir() else folder
    # A shard counts once its record is there.
    records = sorted(path for path in root.rglob("*.json") if path.stem.isdecimal())
    if not records and root == folder:
        raise FileError(
            f"{folder}: no shards here, expected the folder that `halfphysics sweep` wrote to"
        )
    return _of_records(records, parts)


def _of_records(records: list[Path], parts: Collection[str] | None) -> Iterator[dict[str, Any]]:
    for record in records:
        shard = record.with_suffix(".tar")
        if not shard.exists():
            shard = record.with_suffix(".h5")
        if not shard.exists():
            raise FileError(
                f"{record.with_suffix('')}: neither .tar nor .h5 is there, expected what "
                f"{record.name} tells of. Run the sweep again in its folder: it is made again"
            )
        yield from read(shard, parts)


def _of_tar(path: Path, parts: Collection[str] | None) -> Iterator[dict[str, Any]]:
    sample: dict[str, Any] = {}
    end = 0
    try:
        with tarfile.open(path, "r|") as archive:
            for member in archive:
                end = member.offset_data + member.size
                key, _, name = member.name.partition(".")
                if not member.isreg() or not name:
                    raise ValueError(f"found {member.name!r} in it, expected NUMBER.human.npz")
                if sample and key != sample["key"]:
                    yield sample
                    sample = {}
                sample.setdefault("key", key)
                part, _, ending = name.rpartition(".")
                handle = archive.extractfile(member)
                if handle is not None and (parts is None or part in parts):
                    sample[part] = _content(handle, ending)
        _check_end(path, end)
    except _DAMAGE as error:
        raise FileError(
            f"{path}: damaged, or no shard of a sweep ({error}). Delete it and run the sweep "
            "again in its folder: what is missing is made again"
        ) from None
    if sample:
        yield sample


def _check_end(path: Path, end: int) -> None:
    """Refuse a tar that does not end as it should: `tarfile` takes damage for the end."""
    with path.open("rb") as handle:
        handle.seek(end)
        rest = handle.read(2 * tarfile.RECORDSIZE)
    if len(rest) < 2 * tarfile.BLOCKSIZE or rest.strip(b"\0"):
        raise ValueError(f"no end of an archive after {end} bytes")


def _content(handle: IO[bytes], ending: str) -> Any:
    data = handle.read()
    if ending == "json":
        return json.loads(data)
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return dict(arrays)
