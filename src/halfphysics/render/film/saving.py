"""Films and pictures as files."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import progress as bars
from halfphysics.base.stopwatch import Stopwatch
from halfphysics.base.validation import file_path, is_whole, shown
from halfphysics.errors import InputError
from halfphysics.render.film import encoding
from halfphysics.render.film.filming import Shoot, workers
from halfphysics.render.film.options import MAX_FPS, FilmOptions

if TYPE_CHECKING:
    from halfphysics.results.result import Result

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

#: Suffixes of films.
FILMS = encoding.FILMS
# A GIF is slow to load: largest default frame rate of one [1/s].
_GIF_FPS = 20.0
# Tolerance for equal times [frames].
_SAME = 1e-6
# Number of pictures from which the palette of a GIF is computed.
_GIF_SAMPLES = 6
# Number of key frames of a sheet with one view, and with several; pictures per row.
_KEYS, _KEYS_OF_VIEWS, _ACROSS = 12, 6, 6
# Size of one view of a sheet [pixels].
_TILE = (300, 340)


def save_film(
    results: Result | Sequence[Result],
    path: str | os.PathLike[str],
    options: FilmOptions | None = None,
    *,
    threads: int | None = None,
    progress: bool = False,
) -> Path:
    """Writes a film: .mp4 (H.264), .webm (VP9) or .gif by the suffix.

    Args:
        results: Results to show; several are shown together, at the same times, and shorter
            ones wait at their end.
        path: The file; whole or not at all.
        options: Cameras, size, speed etc.; None: `FilmOptions()`.
        threads: Worker threads; the film does not depend on it. None: one per core.
        progress: Show a progress bar (`halfphysics.progress`).

    Returns:
        The path written.

    Raises:
        InputError: Options that do not fit the results or the format.
        FileError: The file cannot be written, or the file of a body is missing.
        MissingDependencyError: ffmpeg, which .mp4 and .webm need, is not installed.
    """
    from halfphysics.base.atomic import atomic_path

    shown_results, options = _listed(results), options or FilmOptions()
    path = file_path(path)
    suffix = path.suffix.lower()
    if suffix not in FILMS:
        raise InputError(
            f"path: found {path.name!r}, expected a film, which ends in {', '.join(FILMS)}"
        )
    count = workers(threads)
    rate = film_rate(shown_results, options, suffix)
    encoding.check_film(suffix, options.pixels(len(shown_results)), rate)
    times = film_times(shown_results, options, rate)
    clock = Stopwatch(logger)
    with atomic_path(path) as temporary:  # refuse an impossible path before rendering
        frames = [times * result.fps for result in shown_results]
        shoot = Shoot(shown_results, options, frames, rate=rate, times=times.tolist())
        with bars.asked(progress):
            pictures = _with_bar(shoot, count, bars.bar(len(shoot), "film", "frame"))
        if suffix == ".gif":
            from halfphysics.render.viewpoint import spread

            samples = (shoot.picture(k, count) for k in spread(len(shoot), _GIF_SAMPLES))
            with temporary.open("wb") as file:
                encoding.save_gif(file, pictures, samples, rate)
        else:
            with encoding.encoder(temporary, suffix, shoot.size, rate) as write:
                for picture in pictures:
                    write(picture)
    clock.done("filmed %s, %d pictures", path, len(times), count=len(times), unit="picture")
    return path


def save_picture(
    results: Result | Sequence[Result],
    path: str | os.PathLike[str],
    options: FilmOptions | None = None,
    *,
    frame: int | None = None,
    threads: int | None = None,
) -> Path:
    """Writes a PNG: one frame as in a film, or a sheet of key frames.

    Args:
        results: Results to show; several are shown together, at the same times.
        path: The file; whole or not at all.
        options: Cameras, size etc.; the size of a sheet is that of each of its pictures. Options
            of time (fps, speed, start, end) are for films.
        frame: Frame of the first result, negative from the end; None: a sheet of key frames.
        threads: Worker threads; the picture does not depend on it. None: one per core.

    Returns:
        The path written.

    Raises:
        InputError: No such frame, or options that do not fit the results.
        FileError: The file cannot be written, or the file of a body is missing.
    """
    from PIL import Image

    from halfphysics.base.atomic import atomic_write
    from halfphysics.render.contact_sheet import save_contact_sheet

    shown_results, options = _listed(results), options or FilmOptions()
    for name in ("fps", "speed", "start", "end"):
        if getattr(options, name) != getattr(FilmOptions(), name):
            raise InputError(
                f"{name}: found {getattr(options, name)!r} for a picture, which has no time that "
                "passes. Leave it out"
            )
    first = shown_results[0]
    if frame is not None:
        frame = _checked_frame(frame, len(first.motion))
    count = workers(threads)
    if frame is None and len(shown_results) == 1 and options == _plain(options):
        size = options.size if isinstance(options.size, tuple) else _TILE
        return save_contact_sheet(first, path, size=size, samples=options.samples, threads=count)
    with atomic_write(path) as file:  # refuse an impossible path before rendering
        times = np.arange(len(first.motion)) / first.fps
        if frame is not None:
            shoot = _still(shown_results, options, times)
            Image.fromarray(shoot.picture(frame, count)).save(file, format="PNG")
        else:
            _sheet(shown_results, options, times, count).save(file, format="PNG")
    return Path(path)


def _plain(options: FilmOptions) -> FilmOptions:
    """The options that a contact sheet of one result supports."""
    return FilmOptions(size=options.size, samples=options.samples)


def _still(results: Sequence[Result], options: FilmOptions, times: Array) -> Shoot:
    """The pictures of the first result's frames, from the cameras of a film."""
    frames = [times * result.fps for result in results]
    return Shoot(results, options, frames, rate=results[0].fps, times=times.tolist())


def _sheet(results: Sequence[Result], options: FilmOptions, times: Array, threads: int) -> Any:
    """Key frames beside each other, with captions."""
    from halfphysics.render.contact_sheet import compose, key_frames

    across, down = options.grid(len(results))
    size = options.size or (across * _TILE[0], down * _TILE[1])
    shoot = _still(results, replace(options, size=size, text=False), times)
    several = across * down > 1
    picked = key_frames(results[0], _KEYS_OF_VIEWS if several else _KEYS)
    tiles = [shoot.picture(k, threads) for k in picked]
    columns = max(1, _ACROSS // across)
    return compose(results[0], picked, tiles, columns, shoot.size)


def film_rate(results: Sequence[Result], options: FilmOptions, suffix: str) -> float:
    """Frames per second of the film."""
    if options.fps is not None:
        return float(options.fps)
    own = max(float(result.fps) for result in results)
    most = _GIF_FPS if suffix == ".gif" else MAX_FPS
    return own / max(1, math.ceil(own / most - _SAME))


def film_times(results: Sequence[Result], options: FilmOptions, rate: float) -> Array:
    """Times of the story that the film shows (N,) [s].

    Raises:
        InputError: The film would begin or end after the story.
    """
    last = max((len(result.motion) - 1) / result.fps for result in results)
    tolerance = _SAME / max(result.fps for result in results)
    for name in ("start", "end"):
        given = getattr(options, name)
        if given is not None and given > last + tolerance:
            raise InputError(f"{name}: found {given:g} s, but the story ends at {last:.3f} s")
    end = last if options.end is None else min(options.end, last)
    step = options.speed / rate
    count = int((end - options.start) / step + _SAME) + 1
    return np.asarray(options.start + step * np.arange(count), dtype=np.float64)


def _listed(results: Result | Sequence[Result]) -> list[Result]:
    several: list[Any] = list(results) if isinstance(results, list | tuple) else [results]
    if not several or not all(hasattr(result, "people") for result in several):
        raise InputError(f"results: found {shown(results)}, expected a Result or several")
    return several


def _checked_frame(frame: int, total: int) -> int:
    if not (is_whole(frame, plain=False) and -total <= frame < total):
        raise InputError(
            f"frame: found {shown(frame)}, but the result has {total} frames (0 to {total - 1})"
        )
    return int(frame) % total


def _with_bar(shoot: Shoot, threads: int, bar: Any) -> Iterator[Picture]:
    with bar:
        for picture in shoot.pictures(threads):
            yield picture
            bar.update()
