"""halfphysics judge: clips by everybody's measures, each under its own name."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import (
    BodyOptions,
    File,
    MotionOptions,
    SceneOptions,
    check_output,
    progress,
)
from halfphysics.cli.wording import spoken
from halfphysics.errors import HalfPhysicsWarning, InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.judging.judge import Judged
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

EXAMPLES = """\
halfphysics judge walk.npz run.bvh result.npz
halfphysics judge generated/ --csv measures.csv --page measures.html
halfphysics judge estimates/ --truth mocap/ --scene room.yaml --json measures.json"""

# Most warnings of readers that are printed one by one.
_WARNINGS = 10


@dataclass(frozen=True, kw_only=True)
class Options:
    """How the command line reads clips: a `halfphysics.judging.reading.Reading`."""

    around: SceneOptions = field(default_factory=SceneOptions)
    person: BodyOptions = field(default_factory=BodyOptions)
    motion_file: MotionOptions = field(default_factory=MotionOptions)

    def body(self, own: Body | None, motion: Motion) -> Body:
        """The body of the options, else the motion's own."""
        return self.person.instead_of(own, motion)

    def scene(self) -> Scene | None:
        """The scene of the options; None: there are none."""
        return self.around.load() if self.around.given else None


@dataclass(frozen=True, kw_only=True)
class Command:
    """Judge motions and results by the measures of others and ours (docs/metrics.md, "Judging").

    Such as PhysDiff's physical error, GMD's skating ratio, Kimodo's and EgoEgo's foot sliding,
    IPMAN's stability; with --scene POSA's non-collision and contact; with --truth the errors of
    EMDB. Of a result, the motion that came out is judged, in its scene, on that floor; --frames is
    for results, too. A file that cannot be read is a line of the table, the others go on.
    """

    files: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """Motion and result files, folders of them, or globs in quotes."""
    truth: Annotated[Path | None, tyro.conf.arg(metavar="FILE_OR_FOLDER")] = None
    """The true motion: one file for all clips, or a folder with a file of each clip's name. Of
    several people in it, each is judged against the one of their name."""
    csv: File = None
    """Table to write (.csv): one row per clip."""
    json: File = None
    """Document to write (.json): the same, with definitions and with what could not be measured."""
    page: File = None
    """Page to write (.html): bars over clips for each measure."""
    jobs: int | None = None
    """Processes to work in; one per core if not said. The numbers do not depend on it."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Judge the clips, print the table, write the files."""
        from halfphysics.base.machine import cores
        from halfphysics.cli.judge_tables import brief, text
        from halfphysics.judging.judge import judged
        from halfphysics.judging.tasks import tasks_of

        self._check()
        reading = Options(around=self.scene, person=self.person, motion_file=self.motion_file)
        if self.scene.given:
            self.scene.load()  # a mistake in it is one message, not one for each clip
        tasks = tasks_of(self.files, self.truth)
        jobs = cores() if self.jobs is None else self.jobs
        people = [
            replace(one, error=spoken(one.error), warnings=tuple(map(spoken, one.warnings)))
            for one in judged(tasks, reading, jobs, bar=progress())
        ]
        self._warn(people)
        self._write(people)
        if all(one.verdict is None for one in people):
            causes = "\n  ".join(brief(one.error) for one in people[:_WARNINGS])
            raise InputError(f"no clip could be judged:\n  {causes}")
        print(text(people))
        for path in (self.csv, self.json, self.page):
            if path is not None:
                print(f"written: {path}")

    def _check(self) -> None:
        if not self.files:
            raise InputError("FILE: none given, expected motion files, results or folders of them")
        if self.jobs is not None and self.jobs < 1:
            raise InputError(f"--jobs: found {self.jobs}, expected at least 1")
        for name, suffix in (("csv", ".csv"), ("json", ".json"), ("page", ".html")):
            path: Path | None = getattr(self, name)
            if path is None:
                continue
            if path.suffix.lower() != suffix:
                raise InputError(f"--{name}: found {path}, expected a name that ends in {suffix}")
            check_output(path, *self.files, self.truth, self.scene.scene, self.person.body)

    def _warn(self, people: list[Judged]) -> None:
        said = list(dict.fromkeys(text for one in people for text in one.warnings))
        for message in said[:_WARNINGS]:
            warnings.warn(message, HalfPhysicsWarning, stacklevel=2)
        if len(said) > _WARNINGS:
            more = f"{len(said) - _WARNINGS} more warnings of readers; --json lists them"
            warnings.warn(more, HalfPhysicsWarning, stacklevel=2)

    def _write(self, people: list[Judged]) -> None:
        from halfphysics.base.atomic import atomic_write
        from halfphysics.cli.judge_page import page
        from halfphysics.cli.judge_tables import csv_text, json_text

        writers = ((self.csv, csv_text), (self.json, json_text), (self.page, page))
        for path, made in writers:
            if path is not None:
                with atomic_write(path) as handle:
                    handle.write(made(people).encode("utf-8"))
