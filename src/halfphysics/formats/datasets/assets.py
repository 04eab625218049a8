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
# A clip lies a few folders under the root of its data set (GRAB: grab/s1/cup_lift.npz), whose own
# folder is the first of these.
_PARENTS = 3
_noted: ContextVar[list[Path] | None] = ContextVar("noted", default=None)


def folders(source: Source, options: Options) -> Iterator[Path]:
    """Where assets are looked for, in this order."""
    yield from options.assets
    own = os.environ.get(VARIABLE)
    if own:
        yield Path(own)
    here = source.path.resolve()
    if source.is_folder:
        yield here
    yield from list(here.parents)[:_PARENTS]


def ends(path: str) -> tuple[str, ...]:
    """A path that a file names, and its ends: the folders above it may be called anything.

    A path that leads out of the folder it is looked for in is left out.
    """
    parts = [part for part in path.replace("\\", "/").split("/") if part not in ("", ".")]
    if ".." in parts or (parts and ":" in parts[0]):
        parts = parts[-1:] if parts[-1] != ".." else []
    return tuple("/".join(parts[start:]) for start in range(len(parts)))


@contextmanager
def noted() -> Iterator[list[Path]]:
    """The other files that clips are read from while this lasts, in the order they are found."""
    files: list[Path] = []
    before = _noted.set(files)
    try:
        yield files
    finally:
        _noted.reset(before)


def note(path: Path) -> Path:
    """Say that a file besides the clip's own is read."""
    files = _noted.get()
    if files is not None:
        files.append(path)
    return path


def seek(source: Source, options: Options, names: Iterable[str]) -> Path | None:
    """As `find`, for what need not be there."""
    names = list(names)
    for folder in dict.fromkeys(folders(source, options)):
        for name in names:
            path = folder / name
            if path.is_file():
                return note(path)
    return None


def find(source: Source, options: Options, names: Iterable[str], what: str) -> Path:
    """The first file there is of `names` (paths below the folders).

    Args:
        source, options: Of the clip.
        names: For example "tools/object_meshes/contact_meshes/cup.ply", the best first.
        what: For the message, for example "the mesh of the object 'cup'".

    Raises:
        FileError: There is none: it says what was looked for, and where.
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
