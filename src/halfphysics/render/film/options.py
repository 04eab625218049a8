"""Options of a film: one frozen dataclass for Python and for the command line."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import number
from halfphysics.errors import InputError

#: Cameras: their positions and motions.
CAMERAS = ("auto", "fixed", "follow", "orbit", "front", "back", "left", "right", "top")
#: Default size of one view [pixels].
VIEW = (640, 480)
#: Largest default frame rate of a film [1/s].
MAX_FPS = 60.0
_LEAST, _MOST = 16, 8192  # [pixels]
_RATES = (0.1, 240.0)
_SPEEDS = (0.001, 1000.0)


@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """Options of a film, all with defaults. Raises InputError if one is impossible."""

    camera: tuple[str, ...] = ()
    """Where from: fixed (the whole story in view), follow, orbit, front, back, left, right (of the
    person) or top; several are shown together. None: fixed where people are large, else follow."""
    size: str | tuple[int, int] | None = None
    """Width x height of the whole film, such as 640x480; None: 640x480 for each view."""
    fps: float | None = None
    """Frames per second; None: the result's own, over 60 a whole part of it (of a GIF, over 20)."""
    speed: float = 1.0
    """How fast the story passes: 0.25 is slow motion, in which poses are interpolated."""
    start: float = 0.0
    """Where in the story the film begins [s]."""
    end: float | None = None
    """Where in the story it ends [s]; None: with the story."""
    ghost: bool = True
    """Show the reference, translucent."""
    pressure: bool = False
    """Colour people by the pressure on their skin, where they touch what is soft."""
    label: tuple[str, ...] = ()
    """Text in the corner: one for each result, or one for each view."""
    text: bool = True
    """Show the time and which body is which."""
    dark: bool = False
    """A dark sky and ground."""
    layout: Literal["row", "column"] = "row"
    """Several views beside each other or below each other."""
    samples: int = 2
    """Anti-aliasing: samples x samples points per pixel, 1 to 4."""

    def __post_init__(self) -> None:
        for name in ("camera", "label"):
            given = getattr(self, name)
            object.__setattr__(self, name, (given,) if isinstance(given, str) else tuple(given))
        for camera in self.camera:
            if camera not in CAMERAS:
                hint = did_you_mean(camera, CAMERAS, brackets=True)
                raise InputError(
                    f"camera: found {camera!r}{hint}, expected one of {', '.join(CAMERAS)}"
                )
        object.__setattr__(self, "size", _checked_size(self.size))
        if self.fps is not None:
            number(self.fps, "fps", least=_RATES[0], most=_RATES[1])
        number(self.speed, "speed", least=_SPEEDS[0], most=_SPEEDS[1])
        number(self.start, "start", least=0.0, unit="s")
        if self.end is not None:
            number(self.end, "end", above=self.start, unit="s")
        if self.layout not in ("row", "column"):
            raise InputError(f"layout: found {self.layout!r}, expected row or column")
        if self.samples not in (1, 2, 3, 4):
            raise InputError(f"samples: found {self.samples!r}, expected 1, 2, 3 or 4")

    @property
    def cameras(self) -> tuple[str, ...]:
        """The cameras, at least one."""
        return self.camera or ("auto",)

    def grid(self, results: int) -> tuple[int, int]:
        """Views across and down: with several results and cameras each result is a column."""
        across, down = results, len(self.cameras)
        if min(across, down) == 1:
            across, down = across * down, 1
        return (across, down) if self.layout == "row" else (down, across)

    def pixels(self, results: int) -> tuple[int, int]:
        """Width and height of a picture of `results` results."""
        if isinstance(self.size, tuple):
            return self.size
        across, down = self.grid(results)
        return across * VIEW[0], down * VIEW[1]


def _checked_size(size: object) -> tuple[int, int] | None:
    if size is None:
        return None
    sides: list[object] = []
    if isinstance(size, str):
        found = re.fullmatch(r"\s*(\d{1,6})\s*[xX×,]\s*(\d{1,6})\s*", size)
        sides = [] if found is None else [int(found[1]), int(found[2])]
    elif isinstance(size, tuple | list):
        sides = list(size)
    whole = [int(side) for side in sides if isinstance(side, int | np.integer)]
    if len(sides) != 2 or len(whole) != 2 or not all(_LEAST <= side <= _MOST for side in whole):
        raise InputError(
            f"size: found {size!r}, expected width x height such as 640x480, {_LEAST} to {_MOST} "
            "pixels each"
        )
    return whole[0], whole[1]
