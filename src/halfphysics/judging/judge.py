"""The clips of files, judged in processes; what is wrong with one is told and ends no other."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from halfphysics.base import progress as bars
from halfphysics.base.validation import file_path, is_whole, shown
from halfphysics.base.workers import FULL, Death, Pool
from halfphysics.errors import HalfPhysicsError, HalfPhysicsWarning, InputError
from halfphysics.judging.played import Played, played
from halfphysics.judging.reading import Files, Reading
from halfphysics.judging.tasks import Task, tasks_of
from halfphysics.judging.truths import truth_of

if TYPE_CHECKING:
    from halfphysics.metrics import Verdict
    from halfphysics.motion.motion import Motion
    from halfphysics.results.result import ObjectTrack
    from halfphysics.scene.scene import Scene


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
            Where it holds several people, each is judged against the one of their name, in a result
            also against the one of their place. Of several people only the one of its name is
            judged against a truth of one person.
        scene: Scene file; of a result, its own scene.
        body: Body model, or a folder of them; None: the default body, of a result its own.
        jobs: Processes to work in; None: one a core. The numbers do not depend on it.
        progress: Show a progress bar (`halfphysics.progress`).

    Returns:
        One entry a person, in the order of files. A file that cannot be read has no `verdict`, and
        an `error` that says why.

    Raises:
        FileError: A path that does not exist and fits no file; no motion at all; no truth.
        InputError: `jobs` is no whole number of at least 1, there are no paths, or what should be a
            path is none.
    """
    from halfphysics.base.machine import cores

    if jobs is not None and not is_whole(jobs, least=1, plain=False):
        raise InputError(f"jobs: found {shown(jobs)}, expected a whole number of at least 1")
    given: list[Any]
    if isinstance(paths, str | os.PathLike) or not isinstance(paths, Iterable):
        given = [paths]
    else:
        given = list(paths)
    if not given:
        raise InputError("paths: found none, expected motion or result files, or folders of them")
    reading = Files(
        scene_file=None if scene is None else file_path(scene),
        body_model=None if body is None else file_path(body),
    )
    _scene(reading)  # a mistake in it is one error, not one a clip
    tasks = tasks_of(
        [file_path(path) for path in given], None if truth is None else file_path(truth)
    )
    return judged(tasks, reading, cores() if jobs is None else int(jobs), bar=progress)


def judged(tasks: Sequence[Task], reading: Reading, jobs: int, *, bar: bool) -> list[Judged]:
    """The people of all clips, in the order of the tasks.

    Args:
        tasks: The clips.
        reading: How to read and judge them.
        jobs: Number of processes; 1: none but this one.
        bar: Whether to show a progress bar.
    """
    found: dict[Task, list[Judged]] = {}
    with bars.asked(bar), bars.bar(len(tasks), "judging", "clip") as shown:
        if min(jobs, len(tasks)) == 1:
            for task in tasks:
                try:
                    found[task] = judge_one((task, reading))
                except MemoryError:
                    found[task] = [Judged(task.name, error=f"{task.path}: {FULL}")]
                shown.update()
        else:
            with Pool(judge_one, min(jobs, len(tasks))) as pool:
                for task in tasks:
                    pool.submit((task, reading))
                while answers := pool.wait():
                    for (task, _), answer in answers:
                        if isinstance(answer, Death):
                            answer = [Judged(task.name, error=f"{task.path}: {answer.cause}")]
                        found[task] = answer
                        shown.update()
    return [one for task in tasks for one in found[task]]


def judge_one(item: tuple[Task, Reading]) -> list[Judged]:
    """The people of one clip; whatever is wrong with its file becomes an error in the answer."""
    task, reading = item
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            tasks = _people(task, reading)
            people = [one for its in tasks for one in _judged(its, reading, len(tasks))]
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


def _people(task: Task, reading: Reading) -> list[Task]:
    """A task for each person whom a file tracks, over their own frames; else the task, as of a
    result, whose people share a scene."""
    from halfphysics.formats.format import Source
    from halfphysics.formats.registry import identify
    from halfphysics.formats.results.result_file import is_result

    if task.clip is not None or reading.motion_file.clip is not None or is_result(task.path):
        return [task]
    source = Source(task.path)
    format = identify(source)
    tracks = () if format is None or format.people is None else format.people(source)
    if len(tracks) < 2:
        return [task]
    return [replace(task, clip=track.name) for track in tracks]


def _judged(task: Task, reading: Reading, count: int) -> list[Judged]:
    """The people of a result, or the person of a motion, of `count` whom its file tracks."""
    from halfphysics.formats.results.result_file import is_result
    from halfphysics.metrics import judge

    try:
        scene = _scene(reading)
        if task.clip is None and is_result(task.path):
            return _of_result(task, reading, scene)
        truth = None
        if task.truth is not None:
            truth = truth_of(task.truth, reading.motion_file, task.clip, count=count)
        motion = _motion(task, reading)
        verdict = judge(
            motion, reading.body(None, motion), scene, None if truth is None else truth.motion
        )
        return [Judged(task.name, verdict)]
    except HalfPhysicsError as error:
        return [_failed(task, error)]


def _of_result(task: Task, reading: Reading, scene: Scene | None) -> list[Judged]:
    """The realised motions of a result's people, in its scene with its objects."""
    from halfphysics.metrics.scene_solids import known_tracks

    clip = played(task.path, reading.motion_file)
    # Another scene may have other names, and meshes that the result's own has lost.
    scene = clip.result.scene if scene is None else scene
    objects = known_tracks(scene, clip.objects)
    found = []
    for index, person in enumerate(clip.result.people):
        one = task if len(clip.motions) == 1 else replace(task, clip=person.name)
        try:
            found.append(Judged(one.name, _of_person(clip, index, task, reading, scene, objects)))
        except HalfPhysicsError as error:  # such as no truth of theirs
            found.append(_failed(one, error))
    return found


def _of_person(
    clip: Played,
    index: int,
    task: Task,
    reading: Reading,
    scene: Scene,
    objects: Mapping[str, ObjectTrack],
) -> Verdict:
    """The realised motion of one of a result's people."""
    from halfphysics.metrics import judge

    person, motion, truth = clip.result.people[index], clip.motions[index], None
    if task.truth is not None:
        truth = truth_of(
            task.truth,
            reading.motion_file,
            person.name,
            index=index,
            count=len(clip.motions),
            objects=bool(objects),
        )
    return judge(
        motion,
        reading.body(person.body, motion),
        scene,
        None if truth is None else truth.motion,
        objects=objects,
        truth_objects=None if truth is None else truth.objects,
    )


def _motion(task: Task, reading: Reading) -> Motion:
    how = reading.motion_file
    if task.clip is not None:
        how = replace(how, clip=task.clip)
    return how.load(task.path)


@lru_cache(maxsize=1)
def _scene(reading: Reading) -> Scene | None:
    """The scene, read once in a process."""
    return reading.scene()
