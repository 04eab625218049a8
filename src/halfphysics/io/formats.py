"""What a motion format is, and what it is given to read."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from halfphysics.errors import FileError
from halfphysics.io.npz import Npz
from halfphysics.motion import Motion
from halfphysics.validation import file_path

_HEAD = 4096


class Source:
    """A file to read a motion from, opened as far as a sniffer needs it.

    Raises:
        FileError: The file does not exist, is a folder, is empty or cannot be read.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = file_path(path)
        if not self.path.exists():
            near = self._near()
            raise FileError(f"{self.path}: no such file.{near}")
        if self.path.is_dir():
            raise FileError(f"{self.path}: this is a folder, expected a motion file in it")
        try:
            with self.path.open("rb") as handle:
                #: The first 4096 bytes.
                self.head = handle.read(_HEAD)
        except OSError as error:
            raise FileError(f"{self.path}: cannot read: {error.strerror}") from None
        if not self.head:
            raise FileError(f"{self.path}: the file is empty, expected a motion")

    def _near(self) -> str:
        import difflib

        if not self.path.parent.is_dir():
            return f" The folder {self.path.parent} does not exist either"
        names = [entry.name for entry in self.path.parent.iterdir() if entry.is_file()]
        near = difflib.get_close_matches(self.path.name, names, n=3)
        return f" In that folder: {', '.join(near)}" if near else ""

    @cached_property
    def npz(self) -> Npz | None:
        """Its arrays if it is a zip archive (by content), else None."""
        return Npz(self.path) if self.head[:2] == b"PK" else None


@dataclass(frozen=True, kw_only=True)
class Options:
    """What the caller of `Motion.load` said; None where the file is to say it."""

    fps: float | None = None
    up: str | None = None
    hands: str | None = None
    model: str | os.PathLike[str] | None = None
    gender: str | None = None
    frames: slice = field(default_factory=lambda: slice(None))


@dataclass(frozen=True, kw_only=True)
class Format:
    """One motion file format: a file of its own in this package and a line in the registry."""

    #: Name by which `Motion.save(format=)` and the command line know it.
    name: str
    #: What its files hold, for the message that no format fits.
    expects: str
    #: Whether this file's content is of this format. May raise FileError to explain a near
    #: miss that no other format could claim either.
    sniff: Callable[[Source], bool]
    load: Callable[[Source, Options], Motion]
    #: None where it can only be read.
    save: Callable[[Motion, Path], None] | None = None
