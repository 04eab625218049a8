"""Whether the files that a sweep was made from are still what they were, for one look each.

The reader of a file notes what it contained (SHA-256) and, where it is certain, what the file
looked like then (size, date). A file that still looks so is not read again.
"""

from __future__ import annotations

import os
import stat
import warnings
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from halfphysics.base.digests import sha256_of
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError

T = TypeVar("T")

#: Name of a file -> [size, date in ns].
Stats = Mapping[str, list[int]]
# How many files to remember; variants of one shard share them.
_REMEMBERED = 20_000


class Sources:
    """Looks at files, at each once as long as it is remembered.

    Args:
        since: When the run began [ns]: what changed later may not be what was read.
        base: What names are relative to; files elsewhere go by their whole path.
    """

    def __init__(self, since: int, base: Path = Path()) -> None:
        self._base = os.path.abspath(base)
        self._real = os.path.realpath(base)
        self._since = since
        self._seen: OrderedDict[str, list[int]] = OrderedDict()
        self._warned: set[str] = set()
        self._hashes: OrderedDict[str, str] = OrderedDict()

    def named(self, inputs: Mapping[str, str]) -> dict[str, str]:
        """Paths as names that are the same wherever the plan and its files lie together."""
        return {self._name(path): digest for path, digest in sorted(inputs.items())}

    def _name(self, path: str) -> str:
        whole = os.path.abspath(os.path.join(self._base, path))
        for base in (self._base, self._real):
            if whole.startswith(os.path.join(base, "")):
                return Path(whole).relative_to(base).as_posix()
        return Path(whole).as_posix()

    def _path(self, name: str) -> Path:
        return Path(self._base, name)

    def stats(self, inputs: Mapping[str, str]) -> dict[str, list[int]]:
        """What the files look like that have not changed since the run began."""
        found = {}
        for name in inputs:
            try:
                its = self._path(name).stat()
            except OSError:
                continue  # it is looked at again when the sweep is
            # The date of a folder is not that of what is in its files.
            if stat.S_ISREG(its.st_mode) and max(its.st_mtime_ns, its.st_ctime_ns) < self._since:
                found[name] = [its.st_size, its.st_mtime_ns]
        return found

    def changed(self, inputs: Mapping[str, str], stats: Stats) -> str | None:
        """The first file that is not what it was, or None.

        Args:
            inputs: Name -> SHA-256 of what was read.
            stats: What they looked like, as far as it is known.

        Raises:
            InputError: A file is not there any more.
            FileError: It cannot be read.
        """
        for name, digest in inputs.items():
            if self._look(name) != stats.get(name) and self._hash(name) != digest:
                return name
        return None

    def warn(self, inputs: Mapping[str, str], stats: Stats) -> bool:
        """Whether a file is not what it was, with a warning, one for each file; see `changed`."""
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
