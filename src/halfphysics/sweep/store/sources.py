"""Checks whether the source files of a sweep are unchanged, with one `stat` for each file.

The program that reads a file records its SHA-256 and, where that is safe, its size and date. A file
with the same size and date is not read again.
"""

from __future__ import annotations

import stat
import warnings
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from halfphysics.base.digests import sha256_of
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.sweep.make.source_name import source_name

T = TypeVar("T")

#: Name of a file -> [size, date in ns].
Stats = Mapping[str, list[int]]
# Number of remembered files; variants of one shard share them.
_REMEMBERED = 20_000


class Sources:
    """Checks source files, each only once while it is remembered.

    Args:
        since: Start of the run [ns]: a file that changed later may differ from the content read.
        base: The folder that names are relative to; files elsewhere are named by absolute path.
    """

    def __init__(self, since: int, base: Path = Path()) -> None:
        self._base = Path(base).absolute()
        self._since = since
        self._seen: OrderedDict[str, list[int]] = OrderedDict()
        self._warned: set[str] = set()
        self._hashes: OrderedDict[str, str] = OrderedDict()

    def named(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Paths relative to the plan: the names stay valid if plan and files are moved together."""
        return {source_name(path, self._base): digest for path, digest in sorted(inputs.items())}

    def _path(self, name: str) -> Path:
        return self._base / name

    def stats(self, inputs: Mapping[str, str]) -> dict[str, list[int]]:
        """Size and date of the files that have not changed since the run began."""
        found = {}
        for name in inputs:
            try:
                its = self._path(name).stat()
            except OSError:
                continue  # `changed` checks it again
            # The date of a folder does not change when the content of its files changes.
            if stat.S_ISREG(its.st_mode) and max(its.st_mtime_ns, its.st_ctime_ns) < self._since:
                found[name] = [its.st_size, its.st_mtime_ns]
        return found

    def changed(self, inputs: Mapping[str, str], stats: Stats) -> str | None:
        """The first file that has changed, or None.

        Args:
            inputs: Name -> SHA-256 of the content that was read.
            stats: Name -> size and date, as far as known.

        Raises:
            InputError: A file is missing.
            FileError: A file cannot be read.
        """
        for name, digest in inputs.items():
            if self._look(name) != stats.get(name) and self._hash(name) != digest:
                return name
        return None

    def warn(self, inputs: Mapping[str, str], stats: Stats) -> bool:
        """Whether a file has changed; warns once for each changed file. See `changed`."""
        name = self.changed(inputs, stats)
        if name is not None and name not in self._warned:
            self._warned.add(name)
            warnings.warn(
                f"{name}: has changed since; what was made from it is made again",
                HalfPhysicsWarning,
                stacklevel=3,
            )
        return name is not None

    def _look(self, name: str) -> list[int]:
        known = self._seen.get(name)
        if known is None:
            try:
                its = self._path(name).stat()
            except OSError as error:
                raise InputError(
                    f"{self._path(name)}: cannot be reached ({error.strerror}), but the data in "
                    "the folder was made from it. Put it back, or give another folder (--out)"
                ) from None
            known = [its.st_size, its.st_mtime_ns]
            _remember(self._seen, name, known)
        return known

    def _hash(self, name: str) -> str:
        known = self._hashes.get(name)
        if known is None:
            path = self._path(name)
            try:
                known = sha256_of(path)
            except OSError as error:
                raise FileError(f"{path}: cannot read: {error.strerror}") from None
            _remember(self._hashes, name, known)
        return known


def _remember(seen: OrderedDict[str, T], name: str, value: T) -> None:
    seen[name] = value
    if len(seen) > _REMEMBERED:
        seen.popitem(last=False)
