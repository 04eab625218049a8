"""What `halfphysics judge` measures: the clips of its arguments, each in a process of its own."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from halfphysics.base.validation import file_path
from halfphysics.base.workers import FULL, Death, Pool
from halfphysics.cli.options import BodyOptions, MotionOptions, SceneOptions
from halfphysics.errors import FileError, HalfPhysicsError, HalfPhysicsWarning, InputError

if TYPE_CHECKING:
    from halfphysics.metrics import Verdict
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

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


@dataclass(frozen=True, kw_only=True)
class Options:
    """How clips are read and what they are judged against."""

    scene: SceneOptions = field(default_factory=SceneOptions)
    person: BodyOptions = field(default_factory=BodyOptions)
    motion_file: MotionOptions = field(default_factory=MotionOptions)


@dataclass(frozen=True)
class Judged:
    """One person of a clip; `verdict` is None and `error` says why where it could not be read."""

    name: str
    verdict: Verdict | None = None
    error: str = ""
    warnings: tuple[str, ...] = ()


def judge(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    truth: str | os.PathLike[str] | None = None,
    scene: str | os.PathLike[str] | None = None,
    body: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool = False,
) -> list[Judged]:
    """Judge motion and result files by everybody's measures (docs/metrics.md, "Judging").

    For a motion in memory: `halfphysics.metrics.judge`.

    Args:
        paths: Motion and result files, folders of them, or globs.
        truth: The true motion: one file for all clips, or a folder with a file of each clip's name.
        scene: Scene file; of a result, its own scene.
        body: Body model, or a folder of them; None: the default body, of a result its own.
        jobs: Processes to work in; None: one a core. The numbers do not depend on it.
        progress: Show a progress bar.

    Returns:
        One entry a person, in the order of files. A file that cannot be read has no `verdict`, and
        an `error` that says why.

    Raises:
        FileError: A path that does not exist and fits no file; no motion at all; no truth.
        InputError: `jobs` is not positive.
    """
    from halfphysics.base.machine import cores

    if jobs is not None and (not isinstance(jobs, int) or jobs < 1):
        raise InputError(f"jobs: found {jobs!r}, expected at least 1")
    given = [paths] if isinstance(paths, str | os.PathLike) else list(paths)
    around = SceneOptions(scene=None if scene is None else file_path(scene))
    person = BodyOptions(body=None if body is None else file_path(body))
    options = Options(scene=around, person=person)
    _scene(around)  # a mistake in it is one error, not one a clip
    tasks = tasks_of([file_path(path) for path in given], None if truth is None else Path(truth))
    return judged(tasks, options, cores() if jobs is None else jobs, bar=progress)


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


def judged(tasks: Sequence[Task], options: Options, jobs: int, *, bar: bool) -> list[Judged]:
    """The people of all clips, in the order of the tasks.

    Args:
        tasks: The clips.
        options: How to read and judge them.
        jobs: Number of processes; 1: none but this one.
        bar: Whether to show a progress bar.
    """
    from tqdm import tqdm

    found: dict[Task, list[Judged]] = {}
    with tqdm(total=len(tasks), unit=" clips", leave=False, disable=not bar) as shown:
        if min(jobs, len(tasks)) == 1:
            for task in tasks:
                try:
                    found[task] = judge_one((task, options))
                except MemoryError:
                    found[task] = [Judged(task.name, error=f"{task.path}: {FULL}")]
                shown.update()
        else:
            with Pool(judge_one, min(jobs, len(tasks))) as pool:
                for task in tasks:
                    pool.submit((task, options))
                while answers := pool.wait():
                    for (task, _), answer in answers:
                        if isinstance(answer, Death):
                            answer = [Judged(task.name, error=f"{task.path}: {answer.cause}")]
                        found[task] = answer
                        shown.update()
    return [one for task in tasks for one in found[task]]


def judge_one(item: tuple[Task, Options]) -> list[Judged]:
    """The people of one clip; whatever is wrong with its file becomes an error in the answer."""
    task, options = item
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            tasks = _people(task, options)
            people = [one for its in tasks for one in _judged(its, options)]
        except MemoryError:
            raise
        except Exception as error:  # a fault of a reader must not end the others
            people = [_failed(task, error)]
    said = tuple(str(w.message) for w in caught if issubclass(w.category, HalfPhysicsWarning))
    return [replace(one, warnings=said) for one in people]


def _failed(task: Task, error: Exception) -> Judged:
    """An error as an answer; its text names the file."""
    known = isinstance(error, HalfPhysicsError)
    text = str(error) if known else f"{type(error).__name__}: {error}"
    named = text if str(task.path) in text else f"{task.name}: {text}"
    return Judged(task.name, error=named)


def _people(task: Task, options: Options) -> list[Task]:
    """A task for each person whom a file tracks, over their own frames; else the task."""
    from halfphysics.formats.format import Source
    from halfphysics.formats.registry import identify

    if task.clip is not None or options.motion_file.clip is not None:
        return [task]
    source = Source(task.path)
    format = identify(source)
    tracks = () if format is None or format.people is None else format.people(source)
    if len(tracks) < 2:
        return [task]
    return [replace(task, clip=track.name) for track in tracks]


def _judged(task: Task, options: Options) -> list[Judged]:
    """The people of a result, or the person of a motion."""
    from halfphysics.formats.results.result_file import is_result
    from halfphysics.metrics import judge

    try:
        truth = None if task.truth is None else _motion(Task(task.truth), options)
        scene = _scene(options.scene)
        if task.clip is None and is_result(task.path):
            return _of_result(task, options, scene, truth)
        motion = _motion(task, options)
        return [Judged(task.name, judge(motion, options.person.load(motion), scene, truth))]
    except HalfPhysicsError as error:
        return [_failed(task, error)]


def _of_result(
    task: Task, options: Options, scene: Scene | None, truth: Motion | None
) -> list[Judged]:
    """The realised motions of a result's people, in its scene with its objects."""
    from halfphysics.metrics import judge
    from halfphysics.results.result import Result

    result = Result.load(task.path, scene=scene)
    several = len(result.people) > 1
    return [
        Judged(
            f"{task.name}:{person.name}" if several else task.name,
            judge(
                person.motion,
                options.person.instead_of(person.body, person.motion),
                result.scene,
                truth,
                objects=result.objects,
            ),
        )
        for person in result.people
    ]


def _motion(task: Task, options: Options) -> Motion:
    reading = options.motion_file
    if task.clip is not None:
        reading = replace(reading, clip=task.clip)
    return reading.load(task.path)


@lru_cache(maxsize=1)
def _scene(options: SceneOptions) -> Scene | None:
    """The scene, read once in a process."""
    return options.load() if options.given else None


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
        same = sorted(p for p in truth.rglob(f"{path.stem}.*") if p.is_file())
        if len(same) != 1:
            raise InputError(
                f"--truth {truth}: found {len(same) or 'no'} files for {path.name}, expected one "
                "of its name. Name the truths as the clips are named"
            )
        found = same[0]
    return found
