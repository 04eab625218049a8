"""halfphysics view: show results in a browser."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from halfphysics.cli.options import BodyOptions, MotionOptions

EXAMPLES = """\
halfphysics view result.npz
halfphysics view soft.npz stiff.npz --port 9000
halfphysics view walk.npz
halfphysics view ws://127.0.0.1:8765"""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Show results and motions in a browser, several side by side; Ctrl-C ends it.

    Files that are dropped onto the page are shown, too. An address ws://... shows the live session
    of `halfphysics serve` that runs there. Prints the address to open. On a machine
    without a display, reach it through an SSH tunnel; the command to do so is printed too.
    """

    files: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="RESULT|MOTION|ADDRESS")
    ]
    """Results of `simulate`, or motion files; the first decides where to look from. Or the address
    of one live session."""
    port: int = 8080
    """Port to listen on; where it is in use, the next one that is free."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0: any machine that reaches this one can look."""

    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion_file: tyro.conf.OmitArgPrefixes[MotionOptions] = field(default_factory=MotionOptions)

    def run(self) -> None:
        """Serve until Ctrl-C."""
        from halfphysics.cli.shown import opened
        from halfphysics.errors import InputError
        from halfphysics.viewer.live_view import is_address, view_live
        from halfphysics.viewer.view import differences, view

        if not self.files:
            raise InputError("view: found no file, expected at least one result or motion")
        if any(map(is_address, self.files)):
            if len(self.files) > 1:
                raise InputError("view: found an address and more, expected one live session alone")
            view_live(self.files[0], host=self.host, port=self.port)
            return
        files = tuple(map(Path, self.files))
        results = opened(files, self.motion_file, self.person)
        notes = differences(results) if len(results) > 1 else [""]
        labels = [name + note for name, note in zip(_names(files), notes, strict=True)]
        view(*results, labels=labels, host=self.host, port=self.port)


def _names(files: tuple[Path, ...]) -> list[str]:
    """File names, with as many folders as needed to be distinct."""
    for parts in range(1, 1 + max(len(path.parts) for path in files)):
        names = ["/".join(path.with_suffix("").parts[-parts:]) for path in files]
        if len(set(names)) == len(files):
            return names
    return [f"{path.stem} ({k + 1})" for k, path in enumerate(files)]
