"""Reads the stored samples of a sweep one by one: from shards, and from unsealed fragments."""

from __future__ import annotations

import json
import tarfile
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from halfphysics.base import json_files
from halfphysics.base.digests import sha256_of
from halfphysics.errors import FileError
from halfphysics.sweep.plan.layout import Layout, key_of
from halfphysics.sweep.store import sealing
from halfphysics.sweep.store.comparing import contents_differ, files_differ
from halfphysics.sweep.store.contents import contents

#: Files of a shard from which samples are read, in order of preference.
_SUFFIXES = (".tar", ".h5")


def ranges_made(layout: Layout) -> Iterator[range]:
    """The variants of every sealed shard and of every fragment of open shards, in order."""
    for shard in range(layout.shards):
        batches = layout.batches_of(shard)
        if layout.shard_file(shard, ".json").is_file():
            yield range(layout.variants_of(batches[0])[0], layout.variants_of(batches[-1])[-1] + 1)
        elif layout.open_shard(shard).is_dir():
            for batch in batches:
                if layout.fragment_record(batch).is_file():
                    yield layout.variants_of(batch)


@dataclass(frozen=True, eq=False)
class Piece:
    """A shard or a fragment: the samples of consecutive variants.

    Attributes:
        record: The record of the shard or fragment.
        files: File -> SHA-256 in the record; samples are read from the first file.
    """

    record: Mapping[str, Any]
    files: Mapping[Path, str]

    @classmethod
    def open(cls, layout: Layout, numbers: range) -> Piece:
        """Open the piece that holds a range of variants from `ranges_made`.

        Raises:
            FileError: The record cannot be read.
        """
        batch = numbers[0] // layout.batch
        shard = layout.shard_of(batch)
        path = layout.shard_file(shard, ".json")
        record = json_files.read(path)
        if record is not None and sealing.whole(record):
            known = record["files"]
            files = {
                layout.shard_file(shard, suffix): known[suffix]["sha256"]
                for suffix in (*_SUFFIXES, *sorted(known.keys() - set(_SUFFIXES)))
                if suffix in known
            }
            return cls(record, files)
        record = json_files.read(layout.fragment_record(batch))
        if record is None:
            raise FileError(
                f"{path}: cannot be read, expected the record of a shard. Run the sweep again in "
                "its folder: what is missing is made again"
            )
        return cls(record, {layout.fragment(batch): record["sha256"]})

    @property
    def inputs(self) -> Mapping[str, str]:
        """The source files of the piece: path -> SHA-256."""
        inputs: Mapping[str, str] = self.record.get("inputs", {})
        return inputs

    @cached_property
    def failed(self) -> frozenset[int]:
        """The variants that failed."""
        return frozenset(failure["number"] for failure in self.record.get("failures", ()))

    def damage(self) -> list[str]:
        """Descriptions of the files that differ from their SHA-256 in the record."""
        words = []
        for path, expected in self.files.items():
            try:
                found = sha256_of(path)
            except OSError as error:
                words.append(
                    f"{path}: cannot be read ({error.strerror}). To have what is missing made "
                    "again, run the sweep"
                )
                continue
            if found != expected:
                words.append(
                    f"{path}: is not what was written (SHA-256 {found[:12]}...). To have it made "
                    "again, delete it and run the sweep"
                )
        return words

    def numbers(self) -> list[int]:
        """The variants that have a sample, in order.

        Raises:
            FileError: The file that holds the samples is missing or damaged.
        """
        return [int(key) for key in self._places if key.isdecimal()]

    def __contains__(self, number: object) -> bool:
        return key_of(number) in self._places if isinstance(number, int) else False

    def card(self, number: int) -> Mapping[str, Any]:
        """The card of a sample; raises one of `contents.DAMAGE`."""
        if self._h5:
            card: Mapping[str, Any] = self._sample(number)["card"]
            return card
        card = json.loads(self._bytes(number)["card.json"])
        return card

    def differ(
        self, number: int, files: Mapping[str, bytes], ignored: Collection[str]
    ) -> list[str]:
        """The differences of a sample from `files`; raises one of `contents.DAMAGE`.

        HDF5 stores arrays, not files: then the contents are compared.
        """
        if not self._h5:
            return files_differ(self._bytes(number), files, ignored)
        there = self._sample(number)
        parts = {name.rpartition(".")[0]: name for name in files}
        words = [f"{part} is not made any more" for part in sorted(there.keys() - parts.keys())]
        for part, name in sorted(parts.items()):
            if part in there:
                words += contents_differ(name, there[part], contents(name, files[name]), ignored)
            else:
                words.append(f"{name} is missing there")
        return words

    @property
    def _path(self) -> Path:
        return next(iter(self.files))

    @property
    def _h5(self) -> bool:
        return self._path.suffix == ".h5"

    @cached_property
    def _places(self) -> Mapping[str, list[tuple[str, int, int]]]:
        """Key -> name, offset and size of each file; no files for HDF5.

        Raises:
            FileError: The file is missing or damaged.
        """
        if not self.record.get("samples", 1):
            return {}  # a fragment without members is no tar
        if self._h5:
            from halfphysics.sweep.store.hdf5 import keys

            return {key: [] for key in keys(self._path)}
        places: dict[str, list[tuple[str, int, int]]] = {}
        try:
            with tarfile.open(self._path, "r:") as archive:
                for member in archive:
                    key, _, name = member.name.partition(".")
                    places.setdefault(key, []).append((name, member.offset_data, member.size))
        except (tarfile.TarError, OSError) as error:
            raise FileError(
                f"{self._path}: damaged ({error}). Delete it and run the sweep again in its "
                "folder: what is missing is made again"
            ) from None
        return places

    def _bytes(self, number: int) -> dict[str, bytes]:
        found = {}
        with self._path.open("rb") as handle:
            for name, offset, size in self._places[key_of(number)]:
                handle.seek(offset)
                found[name] = handle.read(size)
        return found

    def _sample(self, number: int) -> dict[str, Any]:
        from halfphysics.sweep.store.hdf5 import sample

        found = sample(self._path, key_of(number))
        del found["key"]
        return found
