"""The folder of a sweep: its contents, the remaining work, and safety against interruption.

Every file appears complete or not at all, and is valid once its record exists. A process that is
killed at any moment leaves valid and invalid files; the next start removes the invalid ones.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.base import json_files
from halfphysics.base.code_hash import code_hash
from halfphysics.base.json_files import reported
from halfphysics.errors import FileError, InputError
from halfphysics.sweep.plan.layout import INPUTS, PLAN, Layout
from halfphysics.sweep.store import hdf5, manifest, reopening, sealing
from halfphysics.sweep.store.fixed_code import check_code, check_same
from halfphysics.sweep.store.fixed_inputs import check_inputs
from halfphysics.sweep.store.fixed_plan import check_plan
from halfphysics.sweep.store.fragments import Fragments, Sample
from halfphysics.sweep.store.locking import Lock
from halfphysics.sweep.store.sources import Sources

if TYPE_CHECKING:
    from halfphysics.sweep.plan.plan import Plan

# Largest difference between the clocks of a machine and of its file server [ns].
_CLOCKS = 2_000_000_000


class Store:
    """The folder of a sweep.

    A driver calls `begin` first and `finish` at the end; workers write fragments and seal shards,
    from any process. If two workers do the same work, the bytes are the same.

    Args:
        folder: Path of the folder, which may not exist yet.
        plan: The plan of the sweep.
        code: Hash of the code that makes the data; None: hash of this code.
        remake: Make data of other code again, instead of refusing the folder.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        plan: Plan,
        code: str | None = None,
        *,
        remake: bool = False,
    ) -> None:
        self.folder = Path(folder)
        self.plan = plan
        self._remake = remake
        self._code = code = code_hash() if code is None else code
        self.identity = hashlib.sha256(f"{plan.identity} {code}".encode()).hexdigest()
        self._lock = Lock(self.folder / "work" / "driver.lock")

    # -- the folder ------------------------------------------------------------------------

    @cached_property
    def layout(self) -> Layout:
        """The variants, batches and shards of the sweep, and their paths."""
        from halfphysics.sweep.plan.inputs import InputList
        from halfphysics.sweep.plan.variants import Variants

        outputs = self.plan.outputs
        variants = len(Variants(self.plan, InputList(self.folder / INPUTS)))
        return Layout(self.folder, variants, outputs.batch, outputs.variants_per_shard)

    @cached_property
    def _sources(self) -> Sources:
        try:
            since = os.stat(self._lock.path).st_mtime_ns - _CLOCKS
        except OSError:
            since = 0  # the sweep has not started: sizes and dates of files prove nothing
        return Sources(since, self.plan.base)

    @cached_property
    def _fragments(self) -> Fragments:
        return Fragments(self.layout, self.identity, self._sources)

    def begin(self) -> None:
        """Create or open the folder, lock it, and remove the incomplete files of a killed run.

        Raises:
            InputError: The folder holds another plan, unrelated files, or data of another program;
                the list of inputs has changed; or another sweep works in it.
            FileError: The folder cannot be written.
            MissingDependencyError: The plan requests HDF5 and h5py is not installed.
        """
        if self.folder.exists() and not self.folder.is_dir():
            raise FileError(
                f"{self.folder}: this is a file, expected a folder. Give another (--out)"
            )
        if "hdf5" in self.plan.outputs.formats:
            hdf5.check()
        if self.folder.is_dir() and not (self.folder / PLAN).exists():
            self._check_empty()
        self._lock.take()
        try:
            self._begin()
        except BaseException:
            self._lock.release()
            raise

    def _begin(self) -> None:
        from halfphysics.sweep.plan.plan import resolve_inputs

        self._clean(self.folder)
        there = check_plan(self.folder, self.plan)
        if there is None or there.base.resolve() != self.plan.base.resolve():
            self.plan.save(self.folder / PLAN)
        check_inputs(self.folder / INPUTS, resolve_inputs(self.plan, self.folder))
        layout = self.layout
        check_code(layout, self._code, self.identity, remake=self._remake)
        for folder in (layout.shard_folder, layout.work):
            with reported(folder):
                folder.mkdir(exist_ok=True)
        for parent in (layout.shard_folder, layout.work):
            for folder in sorted(p for p in parent.iterdir() if p.is_dir()):
                self._clean(folder)
        self._remove_sealed()

    def join(self) -> None:
        """Open the folder in a worker, which calls this instead of `begin`.

        Raises:
            InputError: Another program started the sweep.
        """
        check_same(self.layout, self._code)

    def close(self) -> None:
        """Unlock the folder."""
        self._lock.release()

    def __enter__(self) -> Store:
        self.begin()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_empty(self) -> None:
        others = sorted(
            p.name
            for p in self.folder.iterdir()
            if p.name not in ("work", INPUTS) and not p.name.endswith(".part")
        )
        if others:
            raise InputError(
                f"{self.folder}: found {', '.join(others[:5])}{', ...' * (len(others) > 5)} and no "
                "plan.yaml, expected an empty folder or that of a sweep. Give another (--out)"
            )

    @staticmethod
    def _clean(folder: Path) -> None:
        """Remove the incomplete files of a killed process."""
        with reported(folder):
            for path in sorted(folder.glob(".*.part")):
                path.unlink(missing_ok=True)

    def _remove_sealed(self) -> None:
        """Remove the fragments of sealed shards."""
        for folder in sorted(p for p in self.layout.work.iterdir() if p.name.isdecimal()):
            if self.done(int(folder.name)):
                self._fragments.remove(int(folder.name))

    # -- finished work -------------------------------------------------------------------------

    def batches(self, shard: int) -> range:
        """The batches of a shard."""
        return self.layout.batches_of(shard)

    def record(self, shard: int) -> dict[str, Any] | None:
        """The record of a shard that this program sealed for this plan, else None."""
        record = json_files.read(self.layout.shard_file(shard, ".json"))
        if record is None or record.get("of") != self.identity or record.get("shard") != shard:
            return None
        return record if sealing.whole(record) else None

    def done(self, shard: int) -> bool:
        """Whether a shard is sealed, its files have the recorded sizes and inputs are unchanged.

        Raises:
            InputError: A source file is missing.
        """
        record = self.record(shard)
        if record is None or not sealing.sizes_fit(self.layout, record):
            return False
        return self._sources.changed(record["inputs"], self._stats(shard)) is None

    def _stats(self, shard: int) -> dict[str, Any]:
        return json_files.read(self.layout.stats(shard)) or {}

    def left(self, shard: int) -> list[int]:
        """The batches of a shard that have to be made, in order.

        Warns if a changed source file is the reason.

        Raises:
            InputError: A source file is missing.
        """
        if self.done(shard):
            return []
        record = self.record(shard)
        if record is not None:
            self._sources.warn(record["inputs"], self._stats(shard))
        if not self.layout.open_shard(shard).is_dir():
            return list(self.batches(shard))  # one file access instead of one per batch
        return [b for b in self.batches(shard) if not self._fragments.current(b)]

    def records(self) -> Iterator[dict[str, Any]]:
        """The records of all sealed shards, in order, one at a time."""
        for shard in range(self.layout.shards):
            record = self.record(shard)
            if record is not None:
                yield record

    # -- writing ---------------------------------------------------------------------------

    def write_fragment(
        self, batch: int, samples: Iterable[Sample], record: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Write the samples of a batch as the iterable yields them.

        Args:
            batch: Its number.
            samples: Key and files (name -> content) of each variant that is kept, in order.
            record: Other entries of the record: "skipped", "failures", "sums", "inputs" (path ->
                SHA-256 of the content read). It is read after the last sample, so the caller may
                fill it while the samples are made.

        Returns:
            The record as written: with "samples", "bytes" and "sha256".

        Raises:
            FileError: The fragment cannot be written (a full disk); no partial file remains.
        """
        return self._fragments.write(batch, samples, record)

    def seal(self, shard: int) -> None:
        """Make the files of a shard from its fragments; a finished shard is left as it is.

        Raises:
            FileError: A fragment is missing or damaged, or the shard cannot be written.
            InputError: A source file changed while the fragments were made.
        """
        if not self.done(shard):
            formats = self.plan.outputs.formats
            sealing.seal(self.layout, self._fragments, self.identity, formats, shard)
        self._fragments.remove(shard)

    def drop_failed(self) -> int:
        """Make all batches with failures count as missing; returns the number of failed variants.

        Raises:
            InputError: A source file of a shard is missing.
            FileError: A shard is damaged, or a file cannot be written.
        """
        count = 0
        for shard in range(self.layout.shards):
            record = self.record(shard)
            if record is not None:
                if record["failures"]:
                    count += len(record["failures"])
                    if not self.done(shard):
                        continue  # the whole shard is made again anyway
                    reopening.reopen(self.layout, self._fragments, record)
                continue
            if self.layout.open_shard(shard).is_dir():
                for batch in self.layout.batches_of(shard):
                    fragment = self._fragments.read(batch)
                    if fragment is not None and fragment.get("failures"):
                        count += len(fragment["failures"])
                        self._fragments.forget(batch)
        return count

    def finish(self) -> dict[str, Any]:
        """Write manifest, data card and list of failures of all sealed shards.

        Returns:
            The numbers of shards, samples, skipped variants and failures.
        """
        self._remove_sealed()
        return manifest.write(self.plan, self.layout, self.records())
