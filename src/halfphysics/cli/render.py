"""halfphysics render: a page, a film or a picture of results."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import BodyOptions, MotionOptions, check_output, progress
from halfphysics.errors import InputError
from halfphysics.render.film.options import FilmOptions

if TYPE_CHECKING:
    from halfphysics.results.result import Result

EXAMPLES = """\
halfphysics render result.npz film.mp4
halfphysics render result.npz page.html
halfphysics render walk.npz walk.mp4
halfphysics render result.npz standing.html --support
halfphysics render result.npz slow.mp4 --camera follow --camera top --speed 0.25 --start 2 --end 3
halfphysics render limp.npz stiff.npz film.mp4 --label limp --label stiff --camera orbit
halfphysics render result.npz strip.png
halfphysics render result.npz still.png --frame 120 --size 1280x720"""


@dataclass(frozen=True, kw_only=True)
class SourceOptions(MotionOptions):
    """What a motion file cannot say itself."""

    fps: Annotated[float | None, tyro.conf.arg(name="motion-fps")] = None
    """Frames per second of the motion file, where it does not say; --fps is that of the film."""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Show results or motions: a page to send (.html), a film (.mp4, .webm, .gif) or a picture
    (.png).

    The suffix of OUT says which. Body and ghost (the motion as recorded) are drawn by the package
    itself: no GPU and no display are needed. Several results are shown together.
    """

    files: Annotated[
        tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="RESULT|MOTION... OUT")
    ]
    """Results of `simulate` or motion files, and the file to write."""
    frame: int | None = None
    """Of a picture: the frame to show, negative ones from the end; without it key frames."""
    support: bool = False
    """Of a page: also show what holds the people up: pressure on the skin, forces, centres of
    pressure and of mass."""
    threads: int | None = None
    """Workers; what is written does not depend on it. None: one a core."""
    film: tyro.conf.OmitArgPrefixes[tyro.conf.UseAppendAction[FilmOptions]] = field(
        default_factory=FilmOptions
    )
    person: tyro.conf.OmitArgPrefixes[BodyOptions] = field(default_factory=BodyOptions)
    motion: tyro.conf.OmitArgPrefixes[SourceOptions] = field(default_factory=SourceOptions)

    def run(self) -> None:
        """Write the page, film or picture."""
        from halfphysics.cli.shown import opened

        if len(self.files) < 2:
            raise InputError(
                "render: found one file, expected a result and the file to write, such as "
                "halfphysics render result.npz film.mp4"
            )
        *sources, out = self.files
        kind = self._kind(out)
        if self.frame is not None and kind != "picture":
            raise InputError(f"--frame: {out} is a {kind}; a frame is for a .png")
        if self.support and kind != "page":
            raise InputError(f"--support: {out} is a {kind}; support is shown on a page (.html)")
        check_output(out, *sources)
        results = opened(sources, self.motion, self.person)
        if kind == "page":
            self._page(results, sources, out)
        else:
            self._pictures(results, sources, out, kind)
        print(f"{kind}: {out}")

    def _kind(self, out: Path) -> str:
        from halfphysics.render.film import FILMS

        suffix = out.suffix.lower()
        kinds = {".html": "page", ".png": "picture"} | dict.fromkeys(FILMS, "film")
        if suffix not in kinds:
            raise InputError(
                f"{out}: found suffix {suffix!r}, expected {', '.join(kinds)}. RESULT is given "
                "first, the file to write last"
            )
        return kinds[suffix]

    def _page(self, results: list[Result], sources: list[Path], out: Path) -> None:
        from dataclasses import replace

        from halfphysics.viewer.page import MAX_FPS, save_page

        if replace(self.film, fps=None, label=()) != FilmOptions() or len(self.film.label) > 1:
            raise InputError(
                f"{out}: of the options only --fps, --support and one --label (its title) are for "
                "a page, in which the viewer moves the camera and the time"
            )
        names = [source.stem for source in sources]
        save_page(
            results,
            out,
            title=self.film.label[0] if self.film.label else " | ".join(names),
            labels=names,
            max_fps=MAX_FPS if self.film.fps is None else self.film.fps,
            support=self.support,
            progress=progress(),
        )

    def _pictures(self, results: list[Result], sources: list[Path], out: Path, kind: str) -> None:
        from dataclasses import replace

        from halfphysics.render.film import save_film, save_picture

        options = self.film
        if len(results) > 1 and not options.label:
            options = replace(options, label=tuple(source.stem for source in sources))
        if kind == "film":
            save_film(results, out, options, threads=self.threads, progress=progress())
        else:
            save_picture(results, out, options, frame=self.frame, threads=self.threads)
