"""The other files of a data set: object meshes, subject templates, scenes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from halfphysics.errors import FileError
from halfphysics.formats.format import Options, Source

#: The default folder for licensed models and data sets' assets.
VARIABLE = "HALFPHYSICS_MODELS"
# Number of folders above a clip that are searched, its own folder first: the clip is a few folders
# under the root of its data set (GRAB: grab/s1/cup_lift.npz).
_PARENTS = 3
_noted: ContextVar[list[Path] | None] = ContextVar("noted", default=None)


def folders(source: Source, options: Options) -> Iterator[Path]:
    """The folders searched for assets, in this order."""
    yield from options.assets
    own = os.environ.get(VARIABLE)
    if own:
        yield Path(own)
    here = source.path.resolve()
    if source.is_folder:
        yield here
    yield from list(here.parents)[:_PARENTS]


def ends(path: str) -> tuple[str, ...]:
    """A path in a file and its trailing parts: the names of the folders above may differ.

    Of a path that leads out of the folder searched, only the file name is kept.
    """
    parts = [part for part in path.replace("\\", "/").split("/") if part not in ("", ".")]
    if ".." in parts or (parts and ":" in parts[0]):
        parts = parts[-1:] if parts[-1] != ".." else []
    return tuple("/".join(parts[start:]) for start in range(len(parts)))


@contextmanager
def noted() -> Iterator[list[Path]]:
    """The asset files that clips read inside this context, in the order of reading."""
    files: list[Path] = []
    before = _noted.set(files)
    try:
        yield files
    finally:
        _noted.reset(before)


def note(path: Path) -> Path:
    """Record that an asset file is read; returns its path."""
    files = _noted.get()
    if files is not None:
        files.append(path)
    return path


def seek(source: Source, options: Options, names: Iterable[str]) -> Path | None:
    """Like `find`, but None if there is no such file."""
    names = list(names)
    for folder in dict.fromkeys(folders(source, options)):
        for name in names:
            path = folder / name
            if path.is_file():
                return note(path)
    return None


def find(source: Source, options: Options, names: Iterable[str], what: str) -> Path:
    """The first existing file among `names` (paths below the folders).

    Args:
        source, options: Source and options of the clip.
        names: For example "tools/object_meshes/contact_meshes/cup.ply", the preferred first.
        what: Description for the message, for example "the mesh of the object 'cup'".

    Raises:
        FileError: No file exists; the message names the files and folders tried.
    """
    names = list(names)
    path = seek(source, options, names)
    if path is not None:
        return path
    looked = list(dict.fromkeys(folders(source, options)))
    variable = "" if os.environ.get(VARIABLE) else f" or set ${VARIABLE}"
    raise FileError(
        f"{source.path}: needs {what}, which is not in the file. Looked for "
        f"{' or '.join(names)} in {', '.join(str(folder) for folder in looked)}. Name the folder "
        f"with assets={variable}"
    )
