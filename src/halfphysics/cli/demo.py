"""halfphysics demo: simulate, measure and show a built-in story."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from halfphysics.cli.options import check_room, progress
from halfphysics.cli.outputs import open_page
from halfphysics.errors import FileError

EXAMPLES = """\
halfphysics demo
halfphysics demo --open
halfphysics demo --out /somewhere/else"""

_STORY = "doorway"


@dataclass(frozen=True, kw_only=True)
class Command:
    """Play a built-in story, print its measures, write a result, a picture strip and a page.

    A person walks through a doorway too narrow on one side, bumps a table and kicks a ball.
    """

    out: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")] = Path("out/demo")
    """Folder to write into; made if it is not there."""
    open: bool = False
    """Open the page in the browser."""

    def run(self) -> None:
        """Simulate, measure and write the files."""
        from halfphysics import scenarios
        from halfphysics.cli import measures
        from halfphysics.render.contact_sheet import save_contact_sheet
        from halfphysics.simulation.simulate import simulate
        from halfphysics.simulation.simulator import Simulator
        from halfphysics.viewer.page import save_page

        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"{self.out}: cannot make this folder: {error.strerror}") from None
        check_room(self.out, self.out)
        print(scenarios.describe(_STORY))
        story = scenarios.load(_STORY)
        start = time.perf_counter()
        Simulator(story.scene, body=story.body, settings=story.settings)
        prepared = time.perf_counter() - start
        start = time.perf_counter()
        result = simulate(
            story.motion, story.scene, body=story.body, settings=story.settings, progress=progress()
        )
        seconds = time.perf_counter() - start
        rate = (len(result) - 1) / seconds
        print(result.summary())
        print()
        print(measures.of_result(result, 0, progress=progress()))
        print()
        print(
            f"simulated {len(result)} frames in {seconds:.2f} s: {rate:.0f} frames/s, "
            f"{rate / result.fps:.0f} times real time "
            f"(the body's parts and their mass, once a shape: {prepared:.2f} s)"
        )
        written = {
            "result": self.out / "result.npz",
            "pictures": self.out / "strip.png",
            "page": self.out / "demo.html",
        }
        result.save(written["result"])
        save_contact_sheet(result, written["pictures"])
        save_page(result, written["page"], title="halfphysics demo", progress=progress())
        for what, path in written.items():
            note = "  (open it in a browser; it needs no network)" if what == "page" else ""
            print(f"{what + ':':<10}{path}{note}")
        if self.open:
            open_page(written["page"])
