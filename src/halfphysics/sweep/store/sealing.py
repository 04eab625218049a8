"""Sealing: the fragments of a shard become its files, safe against interruption at any point.

The order of writing makes it safe: first the data files, each complete or absent, then the record
of the shard, which makes the shard valid, and only then the fragments are deleted.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from typing import Any

from halfphysics.base import json_files
from halfphysics.base.atomic import atomic_path
from halfphysics.base.digests import sha256_of
from halfphysics.base.json_files import reported
from halfphysics.errors import FileError, InputError
from halfphysics.sweep.plan.layout import Layout
from halfphysics.sweep.store import tar
from halfphysics.sweep.store.fragments import Fragments

_PIECE = 1 << 20
#: The formats that a plan can request: name -> suffix of the file.
SUFFIXES = {"webdataset": ".tar", "hdf5": ".h5"}

# The required keys of a record.
_KEYS = {"files", "inputs", "first", "variants", "samples", "skipped", "failures", "sums"}


def seal(
    layout: Layout, fragments: Fragments, identity: str, formats: Iterable[str], shard: int
) -> None:
    """Make a shard from its fragments.

    Raises:
        FileError: A fragment is missing or damaged, or the shard cannot be written.
        InputError: A source file changed while the fragments were made.
    """
    batches = layout.batches_of(shard)
    records = [_record(layout, fragments, batch) for batch in batches]
    inputs, stats = _inputs(fragments, records)
    files = _write_files(layout, fragments, records, shard, [SUFFIXES[name] for name in formats])
    document = _merged(records) | {
        "of": identity,
        "shard": shard,
        "first": layout.variants_of(batches[0])[0],
        "variants": sum(len(layout.variants_of(batch)) for batch in batches),
        "inputs": inputs,
        "files": files,
    }
    json_files.write(layout.stats(shard), stats)
    json_files.write(layout.shard_file(shard, ".json"), document, lasting=True)


def _record(layout: Layout, fragments: Fragments, batch: int) -> dict[str, Any]:
    record = fragments.read(batch)
    if record is None:
        raise _lost(layout, batch)
    return record


def _lost(layout: Layout, batch: int) -> FileError:
    return FileError(
        f"{layout.fragment(batch)}: missing, or not what was written (a damaged disk?). Start the "
        "same sweep again: what is missing is made again"
    )


def _write_files(
    layout: Layout,
    fragments: Fragments,
    records: list[dict[str, Any]],
    shard: int,
    suffixes: list[str],
) -> dict[str, dict[str, Any]]:
    """Write the files of a shard; returns suffix -> size and SHA-256.

    The tar is always written, as other formats are made from it; it is removed if the plan does not
    request it.
    """
    files = {}
    old = layout.shard_file(shard, ".json")
    with reported(old):  # the old record must not be valid for new files
        old.unlink(missing_ok=True)
    target = layout.shard_file(shard, ".tar")
    keep = ".tar" in suffixes
    path = target if keep else layout.open_shard(shard) / target.name
    with ExitStack() as stack:
        stack.enter_context(reported(path))
        target.parent.mkdir(parents=True, exist_ok=True)
        tar_path = stack.enter_context(atomic_path(path))
        with tar_path.open("wb") as handle:
            whole = _join(layout, fragments, records, handle)
            handle.flush()
            os.fsync(handle.fileno())
        if keep:
            files[".tar"] = whole
        if ".h5" in suffixes:
            from halfphysics.sweep.store.hdf5 import convert
            from halfphysics.sweep.store.reading import read

            made = layout.shard_file(shard, ".h5")
            with reported(made), atomic_path(made) as temporary:
                convert(read(tar_path), temporary)
                with temporary.open("rb+") as handle:
                    os.fsync(handle.fileno())
                files[".h5"] = {
                    "bytes": temporary.stat().st_size,
                    "sha256": sha256_of(temporary),
                }
    return files


def _join(
    layout: Layout, fragments: Fragments, records: list[dict[str, Any]], out: Any
) -> dict[str, Any]:
    """Write the fragments in order and the end of the archive; returns size and SHA-256."""
    digest, size = hashlib.sha256(), 0
    for record in records:
        own = hashlib.sha256()
        path = layout.fragment(record["batch"])
        try:
            source = path.open("rb")
        except OSError as error:
            raise FileError(f"{path}: cannot read: {error.strerror}") from None
        with source:
            while piece := source.read(_PIECE):
                own.update(piece)
                digest.update(piece)
                size += len(piece)
                out.write(piece)
        if own.hexdigest() != record["sha256"]:
            fragments.forget(record["batch"])
            raise _lost(layout, record["batch"])
    end = tar.ending(size)
    digest.update(end)
    out.write(end)
    return {"bytes": size + len(end), "sha256": digest.hexdigest()}


def _inputs(
    fragments: Fragments, records: list[dict[str, Any]]
) -> tuple[dict[str, str], dict[str, list[int]]]:
    """The source files of all fragments: name -> SHA-256, and name -> size and date."""
    inputs: dict[str, str] = {}
    stats: dict[str, list[int]] = {}
    for record in records:
        for path, digest in record["inputs"].items():
            if inputs.setdefault(path, digest) != digest:
                # Only the user knows which of the two versions is right.
                for one in records:
                    if path in one["inputs"]:
                        fragments.forget(one["batch"])
                raise InputError(
                    f"{path}: changed while the sweep read it, expected the same file throughout. "
                    "Leave it alone and start the same sweep again: what was made from it is "
                    "made again"
                )
        stats |= record["stats"]
    return dict(sorted(inputs.items())), dict(sorted(stats.items()))


def _merged(records: list[dict[str, Any]]) -> dict[str, Any]:
    """The sums of the fragments' records."""
    from halfphysics.sweep.store.data_card import DataCard

    card = DataCard()
    for record in records:
        card.add(record)
    return {
        "samples": sum(record["samples"] for record in records),
        "skipped": sum(record.get("skipped", 0) for record in records),
        "failures": [failure for record in records for failure in record.get("failures", ())],
        "sums": card.sums(),
    }


def whole(record: Mapping[str, Any]) -> bool:
    """Whether a record has all required keys: a user may have edited it."""
    return record.keys() >= _KEYS and bool(record["files"])


def sizes_fit(layout: Layout, record: Mapping[str, Any]) -> bool:
    """Whether the files of a shard have the sizes in its record."""
    for suffix, file in record["files"].items():
        try:
            size = layout.shard_file(record["shard"], suffix).stat().st_size
        except OSError:
            return False
        if size != file["bytes"]:
            return False
    return True
