"""Reading the samples of a sweep one at a time, from a folder, a tar or an HDF5 file.

for sample in halfphysics.sweep.read("out"):
    sample["card"]["factors"], sample["human"]["poses"], sample["contact"]["body"]
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any

from halfphysics.base import json_files
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.sweep.store import tar
from halfphysics.sweep.store.contents import DAMAGE, contents
from halfphysics.sweep.store.fixed_code import NAME, OF


def read(
    path: str | os.PathLike[str], parts: Collection[str] | None = None
) -> Iterator[dict[str, Any]]:
    """Samples in the order of their numbers; each is read when the iteration reaches it.

    Args:
        path: A folder of a sweep (of a running sweep, the sealed shards are read; of one that is
            made again by another program, those of the new program, with a warning), or one of
            its shards, .tar or .h5.
        parts: The files of a sample to read, such as ("human", "card"); None: all.

    Yields:
        A dict: "key" (the number as text), "card" (its `card.json`), and for each other file
        its arrays by name: "human", "object", "contact", "human.1" (a second person), "result".

    Raises:
        FileError: `path` is missing, damaged, or not from a sweep. Nothing is unpickled.
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
        from halfphysics.sweep.store.hdf5 import samples

        return samples(path, parts)
    return _of_tar(path, parts)


def _of_folder(folder: Path, parts: Collection[str] | None) -> Iterator[dict[str, Any]]:
    root = folder / "shards" if (folder / "shards").is_dir() else folder
    # A shard exists once its record exists.
    records = sorted(path for path in root.rglob("*.json") if path.stem.isdecimal())
    if not records and root == folder:
        raise FileError(
            f"{folder}: no shards here, expected the folder that `halfphysics sweep` wrote to"
        )
    return _of_records(_current(folder, records), parts)


def _current(folder: Path, records: list[Path]) -> Iterator[Path]:
    """The records of the program that the folder is of: all of them except while it is made again.

    Without the file that names the program (copied shards) that is not known.
    """
    of = (json_files.read(folder / NAME) or {}).get(OF)
    warned = False
    for path in records:
        if of is None or (json_files.read(path) or {}).get("of") == of:
            yield path
        elif not warned:
            warned = True
            warnings.warn(
                f"{path}: was made by another program than the one in {NAME}; such shards are left "
                "out. Run the sweep again in its folder with --remake: they are made again",
                HalfPhysicsWarning,
                stacklevel=3,
            )


def _of_records(records: Iterable[Path], parts: Collection[str] | None) -> Iterator[dict[str, Any]]:
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
    def wanted(name: str) -> bool:
        return parts is None or _part(name) in parts

    try:
        for key, files in tar.samples(path, wanted):
            yield {"key": key} | {_part(name): contents(name, files[name]) for name in files}
    except DAMAGE as error:
        raise FileError(
            f"{path}: damaged, or no shard of a sweep ({error}). Delete it and run the sweep "
            "again in its folder: what is missing is made again"
        ) from None


def _part(name: str) -> str:
    """The key of a file in the dict of a sample: "human" for human.npz."""
    return name.rpartition(".")[0]
