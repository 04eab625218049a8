"""What `simulate` and `scenario` write of a result: file, page, pictures and film."""

from __future__ import annotations

import os
import sys
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from halfphysics.cli.options import check_output, progress
from halfphysics.errors import InputError

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Option -> how its files may end; a film's suffixes are those of `halfphysics.render.film`.
_SUFFIXES: dict[str, tuple[str, ...]] = {"page": (".html",), "pictures": (".png",)}
_FILES = ("out", "page", "pictures", "film")


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What to write."""

    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"], metavar="FILE")] = None
    """Result file to write (.npz); without it only the summary is printed."""
    page: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Page to write (.html) that shows the result in a browser."""
    pictures: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Strip of pictures to write (.png)."""
    film: Annotated[Path | None, tyro.conf.arg(metavar="FILE")] = None
    """Film to write (.mp4, .webm or .gif)."""
    open: bool = False
    """Open the page in the browser."""

    def given(self) -> dict[str, Path]:
        """Option -> the file to write."""
        return {name: path for name in _FILES if (path := getattr(self, name)) is not None}

    def check(self, *inputs: Path | None) -> None:
        """Refuse, before the work, what cannot be written.

        Raises:
            InputError: A suffix that is not the option's, one file for two options, or --open
                without a page.
            FileError: As `check_output`.
            MissingDependencyError: ffmpeg, which some films need, is not installed.
        """
        files = self.given()
        if len({path.absolute() for path in files.values()}) < len(files):
            raise InputError(
                f"{', '.join(f'--{name}' for name in files)}: found one file for two of them"
            )
        for name, path in files.items():
            _check_suffix(name, path)
            check_output(path, *inputs)
        if self.open and self.page is None:
            raise InputError("--open: shows the page in a browser; say where with --page FILE")

    def write(self, result: Result, title: str) -> None:
        """Write the files, and say where they are.

        Args:
            result: The result.
            title: Of the page.
        """
        if self.out is not None:
            result.save(self.out)
            print(f"result: {self.out}")
        if self.pictures is not None:
            from halfphysics.render.contact_sheet import save_contact_sheet

            save_contact_sheet(result, self.pictures)
            print(f"pictures: {self.pictures}")
        if self.film is not None:
            from halfphysics.render.film import save_film

            save_film(result, self.film, progress=progress())
            print(f"film: {self.film}")
        if self.page is not None:
            from halfphysics.viewer.page import save_page

            save_page(result, self.page, title=title, progress=progress())
            print(f"page: {self.page}")
            if self.open:
                open_page(self.page)
        if not self.given():
            print("nothing written; --out FILE keeps the result, --page FILE shows it")


def _check_suffix(name: str, path: Path) -> None:
    from halfphysics.render.film import FILMS
    from halfphysics.writers import is_kind

    if name == "out":
        others = _SUFFIXES | {"film": FILMS}
        for option in (o for o, ends in others.items() if path.suffix.lower() in ends):
            raise InputError(
                f"--out: found {path}, expected a result's name (.npz); --{option} writes {path}"
            )
        if is_kind(path):
            raise InputError(
                f"--out: found {path}, expected a result's name (.npz), from which halfphysics "
                f"convert RESULT {path} makes this"
            )
    suffixes = FILMS if name == "film" else _SUFFIXES.get(name, ())
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(
            f"--{name}: found {path}, expected a name that ends in {' or '.join(suffixes)}"
        )
    if name == "film" and path.suffix.lower() != ".gif":
        from halfphysics.render.film.encoding import ffmpeg

        ffmpeg(path.suffix.lower())


def open_page(page: Path) -> bool:
    """Open a page in the browser; False, quietly, where there is no screen or no browser."""
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        return False  # a browser of the terminal would take it over
    try:
        return webbrowser.open(page.resolve().as_uri())
    except (webbrowser.Error, OSError):
        return False
