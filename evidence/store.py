"""Outcomes on disk, so that no task runs twice.

One JSON file per task, its pictures beside it, each written whole or not at all. An outcome counts
as missing if it is damaged, or if another program, other arguments or other files made it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from evidence.model import Outcome, Task, plain
from evidence.rooms.verify import library
from halfphysics.base import code_hash
from halfphysics.base.atomic import atomic_write
from halfphysics.base.digests import sha256_of
from halfphysics.errors import FileError, InputError

_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_. -]*")


class Store:
    """Outcomes in a folder, which is made with the first outcome."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def load(self, section: str, task: Task) -> Any | None:
        """The values of a task, None if the task has to run."""
        path = self._path(section, task)
        try:
            kept = json.loads(path.read_bytes())
        except (OSError, ValueError):
            return None
        if not isinstance(kept, dict) or kept.get("of") != identity(task):
            return None
        if _sum(kept.get("values")) != kept.get("sum"):
            return None
        for name, expected in kept["pictures"].items():
            found = self.picture(section, task.key, name)
            if found is None or hashlib.sha256(found).hexdigest() != expected:
                return None
        return kept["values"]

    def keep(self, section: str, task: Task, outcome: Outcome, of: Any = None) -> None:
        """Keep an outcome; `of`: the `identity` of the task before it began, if files may change.

        Raises:
            InputError: Values that JSON does not have.
            FileError: The folder cannot be written.
        """
        values = plain(outcome.values, f"{section}/{task.key}")
        path = self._path(section, task)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"{path.parent}: cannot make this folder: {error.strerror}") from None
        sums = {}
        for name, png in outcome.pictures.items():
            with atomic_write(self._picture(section, task.key, name)) as handle:
                handle.write(png)
            sums[name] = hashlib.sha256(png).hexdigest()
        kept = {"of": of or identity(task), "sum": _sum(values), "values": values, "pictures": sums}
        with atomic_write(path) as handle:
            handle.write(json.dumps(kept, indent=1).encode())

    def picture(self, section: str, key: str, name: str) -> bytes | None:
        """The PNG that a task made."""
        path = self._picture(section, key, name)
        return path.read_bytes() if path.is_file() else None

    def _path(self, section: str, task: Task) -> Path:
        return self._place(section, task.key, ".json")

    def _picture(self, section: str, key: str, name: str) -> Path:
        return self._place(section, key, f".{name}.png")

    def _place(self, section: str, key: str, end: str) -> Path:
        parts = (section, *f"{key}{end}".split("/"))
        if not all(_NAME.fullmatch(part) for part in parts):
            raise InputError(
                f"task {key + end!r} of {section!r}: expected letters, digits, spaces, '-', '_', "
                "'.' and '/'"
            )
        return self.folder.joinpath(*parts)


def identity(task: Task) -> dict[str, Any]:
    """The program, function, arguments and input files that an outcome belongs to."""
    return {
        "program": program(),
        "function": task.function,
        "arguments": plain(task.arguments, task.key),
        "inputs": [_file_sum(path) for path in task.inputs],
    }


@cache
def program() -> str:
    """SHA-256 of the code that computes outcomes: of the evidence, of halfphysics, and the library
    that verifies them, if it is there."""
    digest = hashlib.sha256(f"{code_hash.code_hash()} {library()}".encode())
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        digest.update(f"{path.relative_to(folder).as_posix()} {sha256_of(path)}\n".encode())
    return digest.hexdigest()


def _file_sum(path: str) -> str:
    """Hash of the content of a file, or of the list of a folder, whose files may be large."""
    if os.path.isdir(path):
        return _sum(sorted(_entries(path)))
    try:
        return sha256_of(path)
    except OSError:
        return ""  # the task itself reports the error


def _entries(folder: str) -> Iterator[tuple[str, int, int]]:
    for path, _, names in os.walk(folder):
        for name in names:
            file = os.path.join(path, name)
            with contextlib.suppress(OSError):  # removed meanwhile, or a broken link
                about = os.stat(file)
                yield os.path.relpath(file, folder), about.st_size, about.st_mtime_ns


def _sum(values: Any) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
