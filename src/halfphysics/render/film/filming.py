"""Pictures of results: several views in one picture, the same for any number of threads."""

from __future__ import annotations

import itertools
import os
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, shown
from halfphysics.errors import InputError
from halfphysics.render.film.options import FilmOptions
from halfphysics.render.film.overlay import Overlay, Place
from halfphysics.render.film.sampling import sampled
from halfphysics.render.film.tracking import Story, hiding, track
from halfphysics.render.look import DARK, GHOST, LIGHT, PEOPLE
from halfphysics.render.pressure_colors import RAMP
from halfphysics.render.rasterizer import Camera, Look, Surface, render
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.skin_bands import SkinPressures, on_one_scale

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Picture = NDArray[np.uint8]

_SEAM, _SEAM_COLOR = 2, (250, 250, 251)  # between views [pixels]
_LEAST_VIEW = 16  # [pixels]


@dataclass(frozen=True, kw_only=True)
class View:
    """One result from one camera, in a part of the picture.

    Attributes:
        drawing: The meshes; one frame per picture.
        cameras: One per picture.
        statics: Name -> static surface, world frame.
        faint: Names of those that are drawn as glass.
        look: Light and background.
        place: Its part of the picture.
    """

    drawing: Drawing
    cameras: Sequence[Camera]
    statics: Mapping[str, Surface]
    faint: Collection[str]
    look: Look
    place: Place

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        left, top, right, bottom = self.place
        return right - left, bottom - top


class Shoot:
    """Pictures of results at given times, from the cameras of `options`.

    Args:
        results: Results to show, each from every camera.
        options: Options of the film.
        frames: Per result, the fractional frames to show: the same number for each.
        rate: Pictures per second of film.
        times: Times written on the pictures [s]; empty: none.
    """

    def __init__(
        self,
        results: Sequence[Result],
        options: FilmOptions,
        frames: Sequence[NDArray[np.float64]],
        *,
        rate: float,
        times: Sequence[float] = (),
    ) -> None:
        self.options = options
        self.size = options.pixels(len(results))
        places = _places(self.size, len(results), options)
        # `Sampled` has all attributes of a result that `Drawing` uses.
        theme = DARK if options.dark else LIGHT
        drawings = [
            Drawing(cast(Any, sampled(r, f)), theme) for r, f in zip(results, frames, strict=True)
        ]
        self._count = len(frames[0])
        self._pressures: list[SkinPressures | None] = [None] * len(results)
        if options.pressure:
            given = [SkinPressures.of(r, f) for r, f in zip(results, frames, strict=True)]
            self._pressures = [*on_one_scale(given)]
        # Views of one result are beside each other.
        self._views = _views(drawings, options, places, rate)
        key = [("reference", GHOST), ("simulated", PEOPLE[0])] if options.ghost else []
        for pressures in self._pressures[:1]:
            if pressures is not None:
                key += [(f"{1e-3 * pressures.end:g} kPa", RAMP[-1])]
        self._overlay = Overlay(
            self.size,
            [view.place for view in self._views],
            labels=_labels(options, len(results)),
            times=times if options.text else (),
            speed=options.speed,
            key=key if options.text else (),
        )

    def __len__(self) -> int:
        """Number of pictures."""
        return self._count

    def picture(self, index: int, threads: int = 1) -> Picture:
        """Picture number `index` (height, width, 3)."""
        width, height = self.size
        sheet = np.full((height, width, 3), _SEAM_COLOR, dtype=np.uint8)
        cameras = len(self.options.cameras)
        for k, view in enumerate(self._views):
            camera = view.cameras[index]
            story = view.drawing.moving(
                index, ghost=self.options.ghost, pressures=self._pressures[k // cameras]
            )
            left, top, right, bottom = view.place
            still = {**view.statics, **view.drawing.dented(index, view.faint)}
            edges = view.drawing.edges(camera, view.size[1], index)
            sheet[top:bottom, left:right] = render(
                [*still.values(), *story, *edges],
                camera,
                view.size,
                samples=self.options.samples,
                look=view.look,
                threads=threads,
            )
        self._overlay.draw(sheet, index)
        return sheet

    def pictures(self, threads: int) -> Iterator[Picture]:
        """All pictures in order, each by one of `threads` workers."""
        with ThreadPoolExecutor(threads) as pool:
            waiting: deque[Future[Picture]] = deque()
            try:
                for index in range(len(self)):
                    waiting.append(pool.submit(self.picture, index))
                    if len(waiting) > 2 * threads:
                        yield waiting.popleft().result()
                while waiting:
                    yield waiting.popleft().result()
            finally:
                for future in waiting:
                    future.cancel()


def workers(threads: int | None) -> int:
    """A number of threads; None: one for each core that this process may use.

    Raises:
        InputError: Under 1.
    """
    if threads is None:
        allowed: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)
        return len(allowed(0)) if allowed is not None else os.cpu_count() or 1
    if not is_whole(threads, least=1, plain=False):
        raise InputError(f"threads: found {shown(threads)}, expected 1 or more")
    return int(threads)


def _places(size: tuple[int, int], results: int, options: FilmOptions) -> list[Place]:
    """Places of the views: all cameras of the first result, then those of the next."""
    across, down = options.grid(results)
    columns, rows = _cut(size[0], across), _cut(size[1], down)
    cells = [(a, b, c, d) for b, d in rows for a, c in columns]
    if any(c - a < _LEAST_VIEW or d - b < _LEAST_VIEW for a, b, c, d in cells):
        raise InputError(
            f"size: found {size[0]}x{size[1]}, too small for {len(cells)} views; expected at least "
            f"{_LEAST_VIEW} x {_LEAST_VIEW} pixels for each"
        )
    cameras = len(options.cameras)
    if across == results and down == cameras:  # each result is a column
        cells = [cells[c * results + r] for r in range(results) for c in range(cameras)]
    return cells


def _cut(length: int, parts: int) -> list[tuple[int, int]]:
    """Cut a length [pixels] into equal parts with seams between them."""
    ends = np.rint(np.linspace(-_SEAM, length, parts + 1)).astype(int).tolist()
    return [(a + _SEAM, b) for a, b in itertools.pairwise(ends)]


def _views(
    drawings: Sequence[Drawing], options: FilmOptions, places: Sequence[Place], rate: float
) -> list[View]:
    """The views, by result, then by camera; all results have the same cameras."""
    story = Story(drawings, options.ghost)
    paths: dict[tuple[str, tuple[int, int]], list[Camera]] = {}
    views = []
    spots = iter(places)
    for drawing in drawings:
        for name in options.cameras:
            place = next(spots)
            # Sizes of views differ by a pixel; all use one path.
            size = (places[0][2] - places[0][0], places[0][3] - places[0][1])
            if (name, size) not in paths:
                paths[name, size] = track(story, name, size, rate)
            cameras = paths[name, size]
            faint = hiding(drawing, cameras, size)
            views.append(
                View(
                    drawing=drawing,
                    cameras=cameras,
                    statics=drawing.still(faint),
                    faint=faint,
                    look=Look.of(drawing.theme).aimed(
                        cameras[len(cameras) // 2], drawings[0].middle
                    ),
                    place=place,
                )
            )
    return views


def _labels(options: FilmOptions, results: int) -> list[str]:
    """A label for each view.

    Raises:
        InputError: Neither one for each result nor one for each view.
    """
    given, cameras = list(options.label), len(options.cameras)
    if len(given) not in (0, results, results * cameras):
        expected = f"{results}" if cameras == 1 else f"{results} or {results * cameras}"
        raise InputError(f"label: found {len(given)} labels, expected {expected}")
    if len(given) == results:
        return [label for label in given for _ in range(cameras)]
    return given
