"""Files of pressures: a picture, a film or arrays, by the suffix of the name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import file_path, shown
from halfphysics.errors import InputError
from halfphysics.render.film import encoding

Picture = NDArray[np.uint8]

#: What pressures are saved as.
SUFFIXES = (".png", *encoding.FILMS, ".npz")
# Frames of a film per second, at most.
_MOST_FPS = {".gif": 20.0}
# Frames from which the palette of a GIF is computed.
_GIF_SAMPLES = 6


def pressure_path(path: str | os.PathLike[str], frame: int | None) -> Path:
    """The path of a file of pressures, of which `frame` was asked for, if any.

    Raises:
        InputError: Another suffix, or a frame for what is no picture.
    """
    path = file_path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"path: found {path.name!r}, expected a name in {', '.join(SUFFIXES)}")
    if frame is not None and path.suffix.lower() != ".png":
        raise InputError(f"frame: found {shown(frame)} for {path.name}; a frame is for a .png")
    return path


@dataclass(frozen=True, kw_only=True)
class DrawnPressures:
    """Pressures of T frames, drawn as they are needed.

    Attributes:
        arrays: What a .npz holds.
        still: The picture of a .png (height, width, 3).
        moment: The picture of a frame of a film.
        size: Width and height of these [pixels].
        frames: T.
        fps: Frames per second.
    """

    arrays: Callable[[], Mapping[str, NDArray[Any]]]
    still: Callable[[], Picture]
    moment: Callable[[int], Picture]
    size: tuple[int, int]
    frames: int
    fps: float

    def save(self, path: Path) -> Path:
        """Write the file that `pressure_path` gave, whole or not at all; returns it.

        Raises:
            FileError: It cannot be written.
            MissingDependencyError: ffmpeg, which .mp4 and .webm need, is not installed.
        """
        suffix = path.suffix.lower()
        if suffix == ".npz":
            from halfphysics.base.npz import write_npz

            write_npz(path, dict(self.arrays()))
        elif suffix == ".png":
            from PIL import Image

            from halfphysics.base.atomic import atomic_write

            with atomic_write(path) as file:
                Image.fromarray(self.still()).save(file, format="PNG")
        else:
            self._save_film(path, suffix)
        return path

    def _save_film(self, path: Path, suffix: str) -> None:
        from halfphysics.base.atomic import atomic_path

        step = max(1, int(np.ceil(self.fps / _MOST_FPS.get(suffix, 60.0) - 1e-6)))
        rate, frames = self.fps / step, range(0, self.frames, step)
        encoding.check_film(suffix, self.size, rate)
        with atomic_path(path) as temporary:
            if suffix == ".gif":
                chosen = np.unique(np.linspace(0, len(frames) - 1, _GIF_SAMPLES).astype(int))
                samples = self._pictures([frames[k] for k in chosen.tolist()])
                with temporary.open("wb") as gif:
                    encoding.save_gif(gif, self._pictures(frames), samples, rate)
            else:
                with encoding.encoder(temporary, suffix, self.size, rate) as write:
                    for one in self._pictures(frames):
                        write(one)

    def _pictures(self, frames: Sequence[int]) -> Iterator[Picture]:
        for frame in frames:
            yield self.moment(frame)
