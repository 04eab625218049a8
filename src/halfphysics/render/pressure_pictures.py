"""Pressure maps as pictures and films: colours in kPa, a bar that says which, a scale in cm."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.render.look import LIGHT
from halfphysics.render.pressure_colors import scale_end, shades
from halfphysics.render.pressure_files import DrawnPressures, pressure_path
from halfphysics.results.layer_pressure import SHOWN

if TYPE_CHECKING:
    from halfphysics.results.pressure_maps import PressureMap

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

# Largest width and height of the map itself, and the least of the picture [pixels].
_MOST, _LEAST_WIDTH = (760, 560), 420
# Room left, above, right (the bar) and below [pixels].
_LEFT, _ABOVE, _RIGHT, _BELOW = 58, 52, 104, 46
#: Size of text and of small print [pixels].
TEXT, SMALL = 14, 12
_BAR, _LEAST_BAR = 16, 96
_PAPER, _GRID = (255, 255, 255), (214, 218, 224)
#: Colour of text.
INK = tuple(round(255 * c) for c in LIGHT.ink)


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """Where the map is in the picture, and how large its cells are."""

    size: tuple[int, int]
    box: tuple[int, int, int, int]  # left, top, right, bottom
    scale: float  # pixels per metre


def save_pressure(
    made: PressureMap,
    path: str | os.PathLike[str],
    *,
    frame: int | None = None,
    most: float | None = None,
) -> Path:
    """Write a pressure map as a picture, a film or arrays, by the suffix.

    A .npz has `pressure` (T, H, W) [Pa], `cell` [m], `corner` (2,) [m], `fps`, `name` and `side`.

    Args:
        made: The map.
        path: The file, .png, .mp4, .webm, .gif or .npz; whole or not at all.
        frame: Of a picture: the frame, negative from the end; None: the largest pressure of every
            cell over time.
        most: Pressure at the end of the colours [Pa]; None: the largest, rounded up.

    Returns:
        The path written.

    Raises:
        InputError: Another suffix, no such frame, or a frame for what is no picture.
        FileError: The file cannot be written.
        MissingDependencyError: ffmpeg, which .mp4 and .webm need, is not installed.
    """
    path = pressure_path(path, frame)
    end = None if path.suffix.lower() in (".png", ".npz") else _end(made, None, most)
    drawn = DrawnPressures(
        arrays=lambda: arrays_of(made),
        still=lambda: picture(made, frame, most),
        moment=lambda k: picture(made, k, end, even=True),
        size=_layout(made, even=True).size,
        frames=len(made),
        fps=made.fps,
    )
    return drawn.save(path)


def arrays_of(made: PressureMap) -> dict[str, NDArray[Any]]:
    """What a file of a map holds, by name."""
    return {
        "pressure": made.pressure,
        "cell": np.array(made.cell),
        "corner": made.corner,
        "fps": np.array(made.fps),
        "name": np.array(made.name),
        "side": np.array(made.side),
    }


def picture(
    made: PressureMap, frame: int | None = None, most: float | None = None, *, even: bool = False
) -> Picture:
    """A picture (height, width, 3) of a map.

    Args:
        made: The map.
        frame: The frame, negative from the end; None: the largest pressure of every cell.
        most: Pressure at the end of the colours [Pa]; None: the largest, rounded up.
        even: Of even width and height, as films need.

    Raises:
        InputError: No such frame.
    """
    from PIL import Image, ImageDraw, ImageFont

    if frame is not None:
        total = len(made)
        if not is_whole(frame, plain=False) or not -total <= frame < total:
            raise InputError(
                f"frame: found {shown(frame)}, but the map has {total} frames (0 to {total - 1})"
            )
        frame = int(frame) % total
    end = _end(made, frame, most)
    values = made.peak if frame is None else made.pressure[frame]
    layout = _layout(made, even)
    sheet = Image.new("RGB", layout.size, _PAPER)
    left, top, right, bottom = layout.box
    field = Image.fromarray(np.ascontiguousarray(values[::-1], dtype=np.float32))
    smooth = np.asarray(field.resize((right - left, bottom - top), Image.Resampling.BILINEAR))
    painted = np.rint(255.0 * shades(smooth / end)).astype(np.uint8)
    sheet.paste(Image.fromarray(painted), (left, top))
    draw = ImageDraw.Draw(sheet)
    text, small = (ImageFont.load_default(size) for size in (TEXT, SMALL))
    _draw_scale(draw, made, layout, small)
    draw_bar(sheet, (right + 22, top), max(bottom - top, _LEAST_BAR), end, small)
    when = "largest of all frames" if frame is None else f"frame {frame}, {frame / made.fps:.2f} s"
    draw.text((left, 10), f"{made.name}, {made.side}: {when}", fill=INK, font=text)
    draw.text((left, 30), _figures(made, frame, values), fill=INK, font=small)
    return np.asarray(sheet)


def _figures(made: PressureMap, frame: int | None, values: NDArray[np.float32]) -> str:
    largest = f"largest {1e-3 * float(values.max(initial=0.0)):.1f} kPa"
    if frame is None:
        return f"{largest}, up to {made.force.max(initial=0.0):.0f} N"
    square = 1e4 * float(made.area()[frame])
    return f"{largest}, {made.force[frame]:.0f} N, {square:.0f} cm² over {1e-3 * SHOWN:.2g} kPa"


def _end(made: PressureMap, frame: int | None, most: float | None) -> float:
    if most is not None:
        return number(most, "most", above=0.0, unit="Pa")
    values = made.pressure if frame is None else made.pressure[frame]
    return 1e3 * scale_end(1e-3 * float(values.max(initial=0.0)))


def _layout(made: PressureMap, even: bool) -> _Layout:
    rows, columns = made.pressure.shape[1:]
    wide, high = columns * made.cell, rows * made.cell
    scale = min(_MOST[0] / wide, _MOST[1] / high)
    width, height = max(round(wide * scale), 1), max(round(high * scale), 1)
    whole = [
        max(_LEFT + width + _RIGHT, _LEAST_WIDTH),
        _ABOVE + max(height, _LEAST_BAR) + _BELOW,
    ]
    if even:
        whole = [side + side % 2 for side in whole]
    return _Layout(
        size=(whole[0], whole[1]),
        box=(_LEFT, _ABOVE, _LEFT + width, _ABOVE + height),
        scale=scale,
    )


def _draw_scale(draw: Any, made: PressureMap, layout: _Layout, font: Any) -> None:
    """The border, the outline of the thing and ticks in cm from its lower left corner."""
    left, top, right, bottom = layout.box
    draw.rectangle([left, top, right - 1, bottom - 1], outline=_GRID)
    start = np.zeros(2)
    if made.outline is not None:
        ends = (made.outline - made.corner) * layout.scale
        (x0, y0), (x1, y1) = ends
        draw.rectangle([left + x0, bottom - y1, left + x1 - 1, bottom - y0 - 1], outline=INK)
        start = ends[0]
    for axis, length in enumerate((right - left, bottom - top)):
        metres = (length - start[axis]) / layout.scale
        step = next((s for s in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0) if metres / s <= 8.0), 5.0)
        for k in range(int(metres / step + 1e-6) + 1):
            at = start[axis] + k * step * layout.scale
            label = f"{100 * k * step:.0f}" + (" cm" if k == 0 else "")
            if axis == 0:
                draw.line([left + at, bottom, left + at, bottom + 4], fill=INK)
                draw.text((left + at, bottom + 7), label, fill=INK, font=font, anchor="ma")
            else:
                draw.line([left - 5, bottom - at, left - 1, bottom - at], fill=INK)
                if k:
                    draw.text((left - 9, bottom - at), label, fill=INK, font=font, anchor="rm")


def _parts(end: float) -> int:
    """Into how many a scale is cut: four, or five where that gives rounder numbers."""
    return 4 if math.isclose(float(f"{end / 4.0:.2g}"), end / 4.0) else 5


def draw_bar(sheet: Any, corner: tuple[int, int], height: int, end: float, font: Any) -> None:
    """Draw the colours and what they mean on a picture of Pillow's.

    Args:
        sheet: The picture.
        corner: Left and top of the bar [pixels].
        height: Of the bar [pixels].
        end: Pressure at the end of the colours [Pa].
        font: Of the numbers.
    """
    from PIL import Image, ImageDraw

    draw = ImageDraw.Draw(sheet)
    x, top = corner
    share = np.linspace(1.0, 0.0, height)
    strip = np.rint(255.0 * shades(np.tile(share[:, None], (1, _BAR)))).astype(np.uint8)
    sheet.paste(Image.fromarray(strip), corner)
    draw.rectangle([x, top, x + _BAR - 1, top + height - 1], outline=_GRID)
    parts = _parts(end)
    for k in range(parts + 1):
        y = top + round((height - 1) * (1.0 - k / parts))
        draw.line([x + _BAR, y, x + _BAR + 4, y], fill=INK)
        label = f"{1e-3 * end * k / parts:.3g}" + (" kPa" if k == parts else "")
        draw.text((x + _BAR + 8, y), label, fill=INK, font=font, anchor="lm")
