"""Libraries of motions: folders, globs and files of many clips, walked lazily."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfphysics.base.reader_warnings import warn
from halfphysics.base.validation import file_path
from halfphysics.errors import FileError
from halfphysics.formats.format import Format, Source
from halfphysics.formats.registry import identify, load_motion, load_sequence, unknown

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.sequence import Sequence


@dataclass(frozen=True)
class Clip:
    """One motion of a library.

    Attributes:
        path: The file or folder of the clip.
        format: Name of the format.
        name: Name of the clip in a file with several clips, else None.
    """

    path: Path
    format: str
    name: str | None = None
    # The open file, if it has several clips: it is read once for all of them.
    _source: Source | None = field(default=None, repr=False, compare=False)

    def load(self, **options: Any) -> Sequence:
        """Motion and scene, as `load_sequence(path, clip=name, **options)`."""
        return load_sequence(self._source or self.path, clip=self.name, **options)

    def motion(self, **options: Any) -> Motion:
        """The motion alone, as `Motion.load(path, clip=name, **options)`."""
        return load_motion(self._source or self.path, clip=self.name, **options)


def clips(path: str | os.PathLike[str]) -> Iterator[Clip]:
    """The motions in a file, in all files under a folder, or in the files that match a glob.

    Only the heads of files are read until a clip is loaded. Files of unknown format and unreadable
    files are skipped, except a file that `path` names; unreadable folders are skipped with a
    warning. Clips come in the order of file names, each once, even if several links lead to it.

    Args:
        path: For example "AMASS/", "AMASS/**/*_stageii.npz" or one file.

    Raises:
        FileError: The path does not exist, or is a file that is no motion.
    """
    given = file_path(path)
    seen: set[str] = set()  # links may lead back to a folder above them
    if given.exists():
        yield from _under(given, seen, asked=True)
        return
    found = False
    for path in sorted(set(_fitting(Path(given.anchor), given.relative_to(given.anchor).parts))):
        found = True
        yield from _under(path, seen, asked=False)
    if not found:
        raise FileError(f"{given}: no such file or folder, and no file fits it as a pattern")


def _fitting(base: Path, pattern: tuple[str, ...]) -> Iterator[Path]:
    """The paths below `base` that match the parts of a glob, as for glob.glob, but cycles of links
    are followed once: glob.glob lists every path of up to 40 links."""
    if not pattern:
        yield base
    elif pattern[0] == "**":
        for folder in _folders(base, set()):
            yield from _fitting(folder, pattern[1:])
    else:
        for name in glob.glob(pattern[0], root_dir=base):
            yield from _fitting(base / name, pattern[1:])


def _folders(base: Path, seen: set[str]) -> Iterator[Path]:
    """A folder and all folders below it that are not hidden, each once."""
    real = os.path.realpath(base)
    if real in seen or not base.is_dir():
        return
    seen.add(real)
    yield base
    for name in glob.glob("*/", root_dir=base):
        yield from _folders(base / name, seen)


def _under(path: Path, seen: set[str], asked: bool) -> Iterator[Clip]:
    folder = path.is_dir()
    real = os.path.realpath(path)
    if real in seen:
        return
    seen.add(real)
    try:
        source = Source(path)
    except FileError as error:
        if asked:
            raise
        if folder:
            warn(f"{error}. Passed over")
        return
    try:
        format = identify(source)
    except FileError:
        if asked and not folder:
            raise
        format = None
    if format is not None:
        for name in _names(source, format, asked):
            yield Clip(path, format.name, name, None if name is None else source)
    elif asked and not folder:
        raise unknown(source)
    elif folder:
        for entry in sorted(path.iterdir()):
            yield from _under(entry, seen, asked=False)


def _names(source: Source, format: Format, asked: bool) -> Iterable[str | None]:
    """The names of the clips of a file, None for its only one; of an unreadable one none, unless it
    is the one that was asked for."""
    if format.clips is None:
        return (None,)
    try:
        return list(format.clips(source))
    except FileError:
        if asked:
            raise
        return ()
