"""halfphysics page: one HTML file, a recording or with physics."""

from __future__ import annotations

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
    refuse_options,
)
from halfphysics.cli.outputs import open_page
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics page kick_ball --play
halfphysics page lift_suitcase --play --out lift.html --open
halfphysics page walk.npz --object ball=sphere:0.11,mass=0.43,position=1:0:0.11 --play
halfphysics page result.npz --out result.html"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Write one HTML file that needs no server and no network: a recording, or with physics.

    With --play the core runs in the page: drag objects, change masses, friction and stiffness.
    Without it the page plays what was simulated.
    """

    what: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="SCENARIO|MOTION|RESULT")]
    """A built-in scenario (halfphysics scenario --list), a motion file, or a result of `simulate`,
    whose reference, scene and settings --play takes."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="FILE")] = None
    """Page to write (.html); by default the name of what it shows, in this folder."""
    play: bool = False
    """With physics."""
    open: bool = False
    """Open the page in the browser."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Write the page and say how large it is."""
        from halfphysics import scenarios

        name = self.what if self.what in scenarios.names() else Path(self.what).stem
        out = Path(f"{name}.html") if self.out is None else self.out
        if out.suffix.lower() != ".html":
            raise InputError(f"--out: found {out}, expected a name that ends in .html")
        check_output(out, None if self.what in scenarios.names() else Path(self.what))
        if self.play:
            from halfphysics.viewer.play_page import save_play_page

            save_play_page(self._sequence(), out, title=name)
        else:
            from halfphysics.viewer.page import save_page

            save_page(self._result(), out, title=name, progress=progress())
        print(f"page: {out}, {out.stat().st_size / 1e6:.1f} MB; open it in a browser, also offline")
        if self.open:
            open_page(out)

    def _result(self) -> Result:
        """What a recording shows."""
        from halfphysics.formats.results.result_file import is_result, load_result
        from halfphysics.simulation.simulate import simulate

        path = self._path()
        if path is not None and is_result(path):
            self._no_options("a result has its own scene, bodies and frames")
            return load_result(path)
        found = self._sequence()
        return simulate(
            found.motion,
            found.scene,
            body=found.body,
            settings=found.settings,
            allow_mismatch=self.person.allow_mismatch,
            progress=progress(),
        )

    def _sequence(self) -> Sequence:
        """What the physics of the page starts from."""
        from halfphysics import scenarios
        from halfphysics.body.match import check_match
        from halfphysics.formats.results.result_file import is_result, load_result

        path = self._path()
        if path is None:
            self._no_options("a scenario has its own scene, body and motion")
            return scenarios.load(self.what)
        if is_result(path):
            self._no_options("a result has its own scene, bodies and frames")
            return _of_result(load_result(path))
        found = self.motion_file.sequence(
            path, body=self.person.instead_of, ground=self.scene.ground
        )
        if self.play:  # a recording is simulated, which checks
            for motion, body in zip(found.motions, found.bodies, strict=True):
                if body is not None:
                    check_match(motion, body, allow_mismatch=self.person.allow_mismatch)
        return replace(found, scene=self.scene.load(found.scene))

    def _path(self) -> Path | None:
        """The file that is shown; None: a scenario.

        Raises:
            InputError: Neither a scenario nor a file.
        """
        from halfphysics import scenarios
        from halfphysics.base.suggestions import did_you_mean
        from halfphysics.base.validation import file_path

        if self.what in scenarios.names():
            return None
        path = Path(self.what)
        if not path.suffix and not path.exists():
            hint = did_you_mean(self.what, scenarios.names(), otherwise=".")
            raise InputError(
                f"page: found {self.what!r}, which is no scenario and no file{hint} "
                f"Scenarios: {', '.join(scenarios.names())}"
            )
        return file_path(path)

    def _no_options(self, why: str) -> None:
        why += ". The options for scenes, bodies and motion files are for motions; leave them out"
        refuse_options("page", why, self.scene, self.person, self.motion_file)


def _of_result(result: Result) -> Sequence:
    """What a result was made from."""
    from halfphysics.simulation.sequence import Sequence

    people = result.people
    return Sequence(
        tuple(person.reference for person in people),
        result.scene,
        tuple(person.body for person in people),
        result.settings,
    )
