"""Pressure on a person's skin as pictures and films: front and back of the body at rest."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.render.look import LIGHT
from halfphysics.render.pressure_colors import scale_end
from halfphysics.render.pressure_files import DrawnPressures, pressure_path
from halfphysics.render.pressure_pictures import INK, SMALL, TEXT, draw_bar
from halfphysics.render.rasterizer import Camera, Look, Surface, render
from halfphysics.render.skin_bands import banded

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.results.result import Result

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

# Size of each view, and room above and right of them [pixels].
_VIEW, _ABOVE, _RIGHT = (380, 520), 52, 100
# Skin that nothing presses.
_BARE = (0.86, 0.85, 0.84)


def save_skin_pressure(
    result: Result,
    path: str | os.PathLike[str],
    *,
    person: int = 0,
    frame: int | None = None,
    most: float | None = None,
) -> Path:
    """Write the pressure on a person's skin as a picture, a film or arrays, by the suffix.

    A .npz has `pressure` (T, V) [Pa] of the vertices of the body's skin, the `area` (V,) [m^2]
    around each, `fps` and `name`.

    Args:
        result: The result.
        path: The file, .png, .mp4, .webm, .gif or .npz; whole or not at all.
        person: Index into `Result.people`.
        frame: Of a picture: the frame, negative from the end; None: the largest pressure of every
            vertex over time.
        most: Pressure at the end of the colours [Pa]; None: the largest, rounded up.

    Returns:
        The path written.

    Raises:
        InputError: Another suffix, no such frame or person, or nothing soft is pressed.
        FileError: The file cannot be written.
        MissingDependencyError: ffmpeg, which .mp4 and .webm need, is not installed.
    """
    from halfphysics.body.skin_samples import vertex_areas
    from halfphysics.results.skin_pressure import skin_pressure

    path = pressure_path(path, frame)
    still = path.suffix.lower() == ".png"
    pressure = skin_pressure(result, person)
    someone = result.people[person]
    if frame is not None and (
        not is_whole(frame, plain=False) or not -len(result) <= frame < len(result)
    ):
        raise InputError(
            f"frame: found {shown(frame)}, but the result has {len(result)} frames "
            f"(0 to {len(result) - 1})"
        )
    values = pressure.max(axis=0) if frame is None else pressure[frame]
    whole = values if still else pressure
    end = 1e3 * scale_end(1e-3 * float(whole.max(initial=0.0)))
    if most is not None:
        end = number(most, "most", above=0.0, unit="Pa")
    sides = _Sides(someone.body, someone.name, end, result.fps)
    index = None if frame is None else int(frame) % len(result)
    drawn = DrawnPressures(
        arrays=lambda: {
            "pressure": pressure,
            "area": vertex_areas(someone.body.rest_vertices, someone.body.faces)[0],
            "fps": np.array(result.fps),
            "name": np.array(someone.name),
        },
        still=lambda: sides.picture(values, index),
        moment=lambda k: sides.picture(pressure[k], k),
        size=sides.size,
        frames=len(result),
        fps=result.fps,
    )
    return drawn.save(path)


class _Sides:
    """Front and back of a body at rest, coloured by pressure up to `end` [Pa]."""

    def __init__(self, body: Body, name: str, end: float, fps: float) -> None:
        self._name, self._end, self._fps = name, end, fps
        self._skin = Surface(
            vertices=_upright(body), faces=body.faces, color=_BARE, crease=180.0, receives=False
        )
        self._cameras = [
            Camera.framing(self._skin.vertices, (0.0, side, 0.05), size=_VIEW)
            for side in (-1.0, 1.0)
        ]
        self.size = (2 * _VIEW[0] + _RIGHT, _ABOVE + _VIEW[1] + _VIEW[1] % 2)

    def picture(self, values: NDArray[np.floating], frame: int | None) -> Picture:
        """A picture (height, width, 3) of the pressure (V,) [Pa] of a frame, or of all: None."""
        from PIL import Image, ImageDraw, ImageFont

        pieces = banded(self._skin, np.asarray(values, dtype=np.float64), self._end)
        sheet = Image.new("RGB", self.size, (255, 255, 255))
        for k, camera in enumerate(self._cameras):
            look = Look.of(LIGHT).aimed(camera, self._skin.vertices.mean(axis=0))
            view = render(pieces, camera, _VIEW, look=look)
            sheet.paste(Image.fromarray(view), (k * _VIEW[0], _ABOVE))
        draw = ImageDraw.Draw(sheet)
        text, small = (ImageFont.load_default(size) for size in (TEXT, SMALL))
        when = "largest of all frames"
        if frame is not None:
            when = f"frame {frame}, {frame / self._fps:.2f} s"
        draw.text((14, 10), f"{self._name}, skin: {when}", fill=INK, font=text)
        largest = 1e-3 * float(values.max(initial=0.0))
        draw.text((14, 30), f"largest {largest:.1f} kPa; front and back", fill=INK, font=small)
        draw_bar(sheet, (2 * _VIEW[0] + 18, _ABOVE + 20), _VIEW[1] - 40, self._end, small)
        return np.asarray(sheet)


def _upright(body: Body) -> Array:
    """The skin at rest with the head up, facing -y (V, 3) [m]; model files are y-up."""
    rest = np.asarray(body.rest_vertices, dtype=np.float64)
    return np.stack([rest[:, 0], -rest[:, 2], rest[:, 1]], axis=1)
