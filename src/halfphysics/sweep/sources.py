"""Whether the files that a sweep was made from are still what they were, for one look each.

Who reads a file says what it contained (SHA-256). Beside it is noted, where it is certain, what
the file looked like then (size, date). A file that still looks so is not read again.
"""

from __future__ import annotations

import hashlib
import os
from collections import OrderedDict
from collections.abc import Mapping
from typing import TypeVar

from halfphysics.errors import FileError, InputError

T = TypeVar("T")

#: path -> [size, date in ns]
Stats = Mapping[str, list[int]]
# How many files to remember; variants of one shard share them.
_REMEMBERED = 20_000


class Sources:
    """Looks at files, at each once as long as it is remembered.

    Args:
        since: When the run began [ns]: what changed later may not be what was read.
    """

    def __init__(self, since: int) -> None:
        self._since = since
        self._seen: OrderedDict[str, list[int]] = OrderedDict()
        self._hashes: OrderedDict[str, str] = OrderedDict()

    def stats(self, inputs: Mapping[str, str]) -> dict[str, list[int]]:
        """What the files look like that have not changed since the run began."""
        found = {}
        for path in inputs:
            try:
                stat = os.stat(path)
            except OSError:
                continue  # then it is read again
            if max(stat.st_mtime_ns, stat.st_ctime_ns) < self._since:
                found[path] = [stat.st_size, stat.st_mtime_ns]
        return found

    def changed(self, inputs: Mapping[str, str], stats: Stats) -> str | None:
        """The first file that is not what it was, or None.

        Args:
            inputs: path -> SHA-256 of what was read.
            stats: What they looked like, as far as it is known.

        Raises:
            InputError: A file is not there any more.
            FileError: It cannot be read.
        """
        for path, digest in inputs.items():
            if self._look(path) != stats.get(path) and self._hash(path) != digest:
                return path
        return None

    def _look(self, path: str) -> list[int]:
        known = self._seen.get(path)
        if known is None:
            try:
                stat = os.stat(path)
            except OSError as error:
                raise InputError(
                    f"{path}: cannot be reached ({error.strerror}), but the data in this folder "
                    "was made from it. Put it back, or give another folder (--out)"
                ) from None
            known = [stat.st_size, stat.st_mtime_ns]
            _remember(self._seen, path, known)
        return known

    def _hash(self, path: str) -> str:
        known = self._hashes.get(path)
        if known is None:
            try:
                with open(path, "rb") as handle:
                    known = hashlib.file_digest(handle, "sha256").hexdigest()
            except OSError as error:
                raise FileError(f"{path}: cannot read: {error.strerror}") from None
            _remember(self._hashes, path, known)
        return known


def _remember(seen: OrderedDict[str, T], path: str, value: T) -> None:
    seen[path] = value
    if len(seen) > _REMEMBERED:
        seen.popitem(last=False)
