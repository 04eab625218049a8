"""halfphysics play: a simulation in a browser, to play with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.base.suggestions import did_you_mean
from halfphysics.cli.options import BodyOptions, MotionOptions, SceneOptions, refuse_options
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.simulation.sequence import Sequence

EXAMPLES = """\
halfphysics play
halfphysics play push_door
halfphysics play walk.npz
halfphysics play kick_ball walk.npz
halfphysics play walk.npz --object ball=sphere:0.11,mass=0.43,position=1:0:0.11 --port 9000
halfphysics play ws://127.0.0.1:8765"""

#: The scenario that is played by default.
FIRST = "kick_ball"


@dataclass(frozen=True, kw_only=True)
class Command:
    """Play with a simulation in a browser: turn masses, friction, stiffness and strength, drag
    objects about; Ctrl-C ends it.

    Prints the address to open. On a machine without a display, reach it through an SSH tunnel;
    the command to do so is printed too.
    """

    what: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="SCENARIO|MOTION|ADDRESS")
    ] = ()
    """A built-in scenario (halfphysics scenario --list) and motion files, all of which can be
    chosen in the page. A scenario and a motion: the motion in the scenario's scene. Or the address
    ws://... of one live session of `halfphysics serve`, to drag its objects."""
    port: int = 8080
    """Port to listen on; where it is in use, the next one that is free."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0: any machine that reaches this one can play."""
    scene: tyro.conf.OmitArgPrefixes[SceneOptions] = field(default_factory=SceneOptions)
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Serve until Ctrl-C."""
        from halfphysics.viewer.catalog import OWN, Catalog, Choice
        from halfphysics.viewer.live_view import is_address, view_live
        from halfphysics.viewer.playground import play

        if any(map(is_address, self.what)):
            if len(self.what) > 1:
                raise InputError("play: found an address and more, expected one live session alone")
            self._no_options("a live session has a scene and bodies of its own")
            view_live(self.what[0], hands=True, host=self.host, port=self.port)
            return
        places, files = self._sorted()
        if not files:
            self._no_options("a scenario has a scene of its own, a body and a motion")
        catalog = Catalog(files)
        first = next(iter(files), None)
        choice = Choice(places[0], first or OWN) if places else Choice(first or FIRST)
        play(catalog, choice, host=self.host, port=self.port)

    def _no_options(self, why: str) -> None:
        why += (
            ". The options for scenes, bodies and motion files are for motions: give a motion "
            "file, or leave them out"
        )
        refuse_options("play", why, self.scene, self.person, self.motion_file)

    def _sorted(self) -> tuple[list[str], dict[str, Callable[[], Sequence]]]:
        """The scenarios and motion files of the arguments."""
        from halfphysics import scenarios
        from halfphysics.base.validation import file_path

        places, paths = [], []
        for text in self.what:
            if text in scenarios.names():
                places.append(text)
                continue
            path = Path(text)
            if not path.suffix and not path.exists():
                hint = did_you_mean(text, scenarios.names(), otherwise=".")
                raise InputError(
                    f"play: found {text!r}, which is no scenario and no file{hint} "
                    f"Scenarios: {', '.join(scenarios.names())}"
                )
            paths.append(file_path(path))
        if len(places) > 1:
            raise InputError(
                f"play: found {len(places)} scenarios, {', '.join(places)}; expected one. The "
                "page has them all"
            )
        if len(set(paths)) < len(paths):
            raise InputError("play: found one file twice")
        return places, {
            name: partial(self._sequence, path)
            for name, path in zip(_names(paths, scenarios.names()), paths, strict=True)
        }

    def _sequence(self, path: Path) -> Sequence:
        """A motion file as a sequence, as for halfphysics simulate."""
        from halfphysics.body.match import check_match

        found = self.motion_file.sequence(
            path, body=self.person.instead_of, ground=self.scene.ground
        )
        for motion, body in zip(found.motions, found.bodies, strict=True):
            if body is not None:  # `instead_of` has given everybody one
                check_match(motion, body, allow_mismatch=self.person.allow_mismatch)
        return replace(found, scene=self.scene.load(found.scene))


def _names(paths: list[Path], taken: tuple[str, ...]) -> list[str]:
    """File names, with as many folders as needed to be distinct."""
    for parts in range(1, 1 + max((len(path.parts) for path in paths), default=0)):
        names = ["/".join(path.parts[-parts:]) for path in paths]
        if len(set(names)) == len(paths) and not set(names) & set(taken):
            return names
    return [str(path.absolute()) for path in paths]
