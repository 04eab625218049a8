"""Which clips are judged, and against which truth."""

from __future__ import annotations

import glob
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from halfphysics.base.validation import file_path
from halfphysics.errors import FileError, HalfPhysicsError

#: Files under a folder with these suffixes are told of if they cannot be read; others are none.
MOTION_SUFFIXES = (".npz", ".npy", ".pkl", ".pt", ".bvh", ".mcs")


@dataclass(frozen=True)
class Task:
    """One clip to judge: its file, its name in a file of several, and the file of its truth."""

    path: Path
    clip: str | None = None
    truth: Path | None = None

    @property
    def name(self) -> str:
        """File, and name in the file."""
        return str(self.path) if self.clip is None else f"{self.path}:{self.clip}"


def tasks_of(files: Sequence[Path], truth: Path | None) -> list[Task]:
    """The clips in files, folders and globs, each once, with the truth of each.

    Raises:
        FileError: A path that does not exist and fits no file; no motion at all; no truth.
    """
    found: dict[Task, None] = {}
    for given in files:
        for task in _under(file_path(given)):
            found[replace(task, truth=_truth_of(task.path, file_path(given), truth))] = None
    if not found:
        raise FileError(f"{', '.join(map(str, files))}: no motion in it")
    return list(found)


def _under(path: Path) -> Iterator[Task]:
    """The clips of a file, a folder or a glob; a file that is no motion is a task that fails."""
    from halfphysics.formats.library import clips

    if path.is_file():
        try:
            found = [Task(clip.path, clip.name) for clip in clips(path)]
        except HalfPhysicsError:
            found = []
        yield from found or [Task(path)]
        return
    read = [Task(clip.path, clip.name) for clip in clips(path)]
    known = {task.path for task in read}
    if path.is_dir():
        some = sorted(p for p in path.rglob("*") if p.suffix.lower() in MOTION_SUFFIXES)
        for file in some:
            if file.is_file() and not known & {file, *file.parents}:
                read.append(Task(file))
    yield from sorted(read, key=lambda task: (str(task.path), task.clip or ""))


def _truth_of(path: Path, given: Path, truth: Path | None) -> Path | None:
    """The truth of a clip: a file is that of all; in a folder, the file of the same name.

    Raises:
        FileError: None of that name.
    """
    if truth is None:
        return None
    truth = file_path(truth)
    if truth.is_file():
        return truth
    if not truth.is_dir():
        raise FileError(f"--truth {truth}: no such file or folder")
    places = [truth / path.name]
    if given.is_dir():
        places.insert(0, truth / path.relative_to(given))
    found = next((place for place in places if place.exists()), None)
    if found is None:
        same = sorted(p for p in truth.rglob(f"{glob.escape(path.stem)}.*") if p.is_file())
        if len(same) != 1:
            raise FileError(
                f"--truth {truth}: found {len(same) or 'no'} files for {path.name}, expected one "
                "of its name. Name the truths as the clips are named"
            )
        found = same[0]
    return found
