"""halfphysics fix: put the motion of a video estimator or a generator right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import (
    BodyOptions,
    MotionOptions,
    SceneOptions,
    check_output,
    progress,
)
from halfphysics.cli.table import table
from halfphysics.cli.wording import spoken
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.repair.repair import Repair
    from halfphysics.simulation.sequence import Sequence as Motions

EXAMPLES = """\
halfphysics fix hmr4d_results.pt --out fixed.npz
halfphysics fix generated.npz --page before_after.html --out fixed.npz
halfphysics fix walk.npz --smooth 6 --scene room.yaml --out fixed.npz"""

# Measures that a page has room for.
_ON_PAGE = ("Phys-Err", "deepest in the scene", "joints moved")


@dataclass(frozen=True, kw_only=True)
class Command:
    """Put a motion right: the floor found, feet on it and not sliding, nothing inside anything.

    For what video estimators and generators make: people who float, sink, drift, tilt, slide, and
    whose hands are in their bodies. What was found and done is printed, with numbers before and
    after. Without --scene the person stands on a floor at z = 0. A clip that is right comes back as
    it is.
    """

    motion: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="MOTION")]
    """Motion file; of a result everybody's motion, as it came out."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="FILE")] = None
    """Motion file to write, in the format that MOTION came in where that can be written; where its
    files hold one person, each of several gets one, with a number. Without it only the numbers are
    printed."""
    format: str | None = None
    """Format to write, where it is to be another."""
    page: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Page to write (.html): before and after, side by side."""
    result: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Result file to write (.npz): with contacts and forces."""
    smooth: float | None = None
    """Take off jitter above this frequency [Hz], such as 6; without it nothing is smoothed."""
    level: bool = True
    """Put the clip on its ground (height, tilt, drift, slide of the whole clip)."""
    plant: bool = True
    """Keep resting feet in place."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Fix, print what was done, write."""
        from halfphysics.formats import files_of, writer_of
        from halfphysics.repair.repair import fix

        inputs = (self.motion, self.scene.scene, self.person.body)
        for out in (self.out, self.page, self.result):
            if out is not None:
                check_output(out, *inputs)
        self._check_apart([self.out])
        if self.page is not None and self.page.suffix.lower() != ".html":
            raise InputError(f"--page: found {self.page}, expected a name that ends in .html")
        if not self.scene.ground and not self.scene.given:
            raise InputError(
                "--no-ground: found no scene, and without one the person stands on a floor at "
                "z = 0. Add --scene (or --static), or leave out --no-ground"
            )
        sequence = self._sequence()
        if self.out is not None:
            for motion in sequence.motions:
                writer_of(motion, self.out, self.format)  # before the work
            files = files_of(sequence.motions, self.out, self.format)
            for path in files:
                check_output(path, *inputs)
            self._check_apart(files)
        bodies = [body for body in sequence.bodies if body is not None]
        scene = self.scene.load() if self.scene.given else None
        repair = fix(
            list(sequence.motions),
            scene,
            body=bodies,
            smooth=self.smooth,
            level=self.level,
            plant=self.plant,
        )
        self._print(repair)
        if self.out is not None:
            self._save(repair, bodies, self.out)
        if self.result is not None:
            repair.result.save(self.result)
            print(f"result: {self.result}")
        if self.page is not None:
            self._page(repair, bodies, self.page)
            print(f"page: {self.page}")

    def _check_apart(self, motions: Sequence[Path | None]) -> None:
        """Refuse one file for two of the outputs; `motions`: the files of --out."""
        files = [path.resolve() for path in (*motions, self.page, self.result) if path is not None]
        if len(set(files)) < len(files):
            raise InputError(
                "--out, --page and --result: found one file for two of them, expected a name for "
                "each"
            )

    def _sequence(self) -> Motions:
        """The people of the file; of a result all of them, as they came out, in their bodies."""
        from halfphysics.formats.results.result_file import is_result

        if is_result(self.motion):
            return self._of_result()
        return self.motion_file.sequence(
            self.motion, body=self.person.instead_of, ground=self.scene.ground
        )

    def _of_result(self) -> Motions:
        from halfphysics.formats.floor import on_floor
        from halfphysics.results.result import Result
        from halfphysics.scene.scene import Scene
        from halfphysics.simulation.sequence import Sequence as Motions

        if replace(self.motion_file, clip=None, frames=None, floor=None) != MotionOptions():
            raise InputError(
                f"{self.motion}: a result has its own axes, rate and bodies. Of the options for "
                "motion files --clip, --frames and --floor are for results, too; leave out the rest"
            )
        result, clip = Result.load(self.motion), self.motion_file.clip
        people = [person for person in result.people if clip in (None, person.name)]
        if not people:
            names = ", ".join(person.name for person in result.people)
            raise InputError(f"--clip: found {clip!r}, expected one of {self.motion}: {names}")
        part = slice(*(self.motion_file.frame_range() or (None, None)))
        motions = tuple(person.motion[part] for person in people)
        bodies = tuple(
            self.person.instead_of(person.body, motion)
            for person, motion in zip(people, motions, strict=True)
        )
        found = Motions(motions, Scene(), bodies)
        floor = self.motion_file.floor
        return found if floor is None else on_floor(found, floor)

    def _print(self, repair: Repair) -> None:
        from halfphysics.repair.report import measures

        for line in repair.lines:
            print(line)
        rows = [["", "before", "after", "unit"]]
        for measure in measures(repair):
            rows.append(
                [measure.name, f"{measure.before:.2f}", f"{measure.after:.2f}", measure.unit]
            )
        print(table(rows))

    def _save(self, repair: Repair, bodies: list[Body], out: Path) -> None:
        from halfphysics.formats import losses, save_people, writer_of

        motions = repair.motions
        paths = save_people(motions, out, bodies, format=self.format)
        lost = [
            line
            for motion, body in zip(motions, bodies, strict=True)
            for line in losses(motion, out, self.format, body)
        ]
        for loss in dict.fromkeys(lost):
            print(f"not in the file: {spoken(loss)}")
        for path in paths:
            print(f"written: {path} ({writer_of(motions[0], path, self.format).name})")

    def _page(self, repair: Repair, bodies: list[Body], page: Path) -> None:
        """The clip as it came and put right, side by side, with the numbers."""
        from halfphysics.baselines import Kinematic
        from halfphysics.repair.report import measures
        from halfphysics.simulation.simulate import simulate
        from halfphysics.viewer.page import save_page

        scene = repair.result.scene
        # Both are shown as they are: a start in the air is what the page is about.
        before, after = (
            simulate(
                [replace(m, origin=None) for m in motions],
                scene,
                body=bodies,
                settings=Kinematic(substeps=1),
            )
            for motions in (repair.originals, repair.motions)
        )
        numbers = ", ".join(
            f"{m.name} {m.before:.1f} to {m.after:.1f} {m.unit}"
            for m in measures(repair)
            if m.name in _ON_PAGE
        )
        notes = [f"before (left) and after (right): {numbers}", "; ".join(repair.lines)]
        labels = ("before", "fixed")
        save_page(
            [before, after],
            page,
            title=self.motion.name,
            notes=notes,
            labels=labels,
            progress=progress(),
        )
