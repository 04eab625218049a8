"""Fragments: the samples of one batch, as the members of a tar without its end.

A fragment exists once its record exists: a JSON file beside it, written after it, with the
identity of the plan and the program, the size of the fragment and its SHA-256.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

from halfphysics.base import json_files
from halfphysics.base.json_files import reported
from halfphysics.errors import InputError
from halfphysics.sweep.plan.layout import Layout, key_of
from halfphysics.sweep.store import tar
from halfphysics.sweep.store.sources import Sources

#: A sample: its key, and its files by name.
Sample = tuple[str, Mapping[str, bytes]]


class Fragments:
    """Writes and reads the fragments of a folder.

    Args:
        layout: The folder.
        identity: Identity of the plan and the program; fragments of others count as missing.
        sources: Checks the files that fragments were made from.
    """

    def __init__(self, layout: Layout, identity: str, sources: Sources) -> None:
        self._layout = layout
        self._identity = identity
        self._sources = sources

    def write(
        self, batch: int, samples: Iterable[Sample], record: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Write a batch; see `Store.write_fragment`."""
        path = self._layout.fragment(batch)
        keys = [key_of(number) for number in self._layout.variants_of(batch)]
        digest, size, count, last = hashlib.sha256(), 0, 0, ""
        # An old record must not be valid for a new fragment.
        self.forget(batch)
        with json_files.replacing(path) as handle:
            for key, files in samples:
                if key <= last or key not in keys:
                    raise InputError(
                        f"batch {batch}: found a sample {key!r} after {last!r}, expected keys "
                        f"from {keys[0]} to {keys[-1]} that go up"
                    )
                last, count = key, count + 1
                for name, data in files.items():
                    for piece in tar.member(f"{key}.{name}", data):
                        handle.write(piece)
                        digest.update(piece)
                        size += len(piece)
        inputs = self._sources.named(record.get("inputs", {}))
        whole = {
            **record,
            "of": self._identity,
            "batch": batch,
            "samples": count,
            "inputs": inputs,
            "stats": self._sources.stats(inputs),
            "bytes": size,
            "sha256": digest.hexdigest(),
        }
        json_files.write(self._layout.fragment_record(batch), whole)
        return whole

    def read(self, batch: int) -> dict[str, Any] | None:
        """The record of a fragment; None if the fragment is missing."""
        record = json_files.read(self._layout.fragment_record(batch))
        if record is None or record.get("of") != self._identity or record.get("batch") != batch:
            return None
        try:
            size = self._layout.fragment(batch).stat().st_size
        except OSError:
            return None
        return record if size == record.get("bytes") else None

    def current(self, batch: int) -> bool:
        """Whether a fragment exists and its source files are unchanged.

        Warns if they have changed.

        Raises:
            InputError: A source file is missing.
        """
        record = self.read(batch)
        if record is None:
            return False
        return not self._sources.warn(record["inputs"], record["stats"])

    def forget(self, batch: int) -> None:
        """Make a fragment count as missing."""
        path = self._layout.fragment_record(batch)
        with reported(path):
            path.unlink(missing_ok=True)

    def remove(self, shard: int) -> None:
        """Remove all fragments of a shard, and all other files of their folder."""
        folder = self._layout.open_shard(shard)
        if not folder.is_dir():
            return
        with reported(folder):
            for path in sorted(folder.iterdir()):
                path.unlink(missing_ok=True)
            # A worker that was taken for dead may just have finished: the next start cleans up.
            with suppress(OSError):
                folder.rmdir()
