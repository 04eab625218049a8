"""Contact sheet: key frames of a result as one picture."""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.render.look import GHOST, PEOPLE
from halfphysics.render.rasterizer import Camera, Color, Look, render
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.viewpoint import cameras, choose_direction, glass

if TYPE_CHECKING:
    from halfphysics.results.result import Result

_ROWS = 2  # rows of pictures by default
_OCTREE = 2  # Pillow's number of this quantization method
_GAP, _MARGIN, _TEXT = 6, 14, 13  # [px]
_PAPER, _INK, _SOFT_INK = (250, 250, 251), (40, 44, 52), (110, 116, 126)


def key_frames(result: Result, count: int) -> list[int]:
    """Up to `count` frames that tell the story, ascending.

    First and last frame; the first contact of every pair (without planes: feet are always on the
    floor); the frame where body and ghost are furthest apart; further frames in the largest
    gaps.

    Args:
        result: The result to show.
        count: Number of frames, at least 1.
    """
    from halfphysics.geometry.shapes import Plane

    total = len(result.motion)
    if count < 1:
        raise InputError(f"count: found {count}, expected 1 or more")
    if count >= total:
        return list(range(total))
    planes = {n for n, s in result.scene.statics.items() if isinstance(s.shape, Plane)}
    contacts = result.contacts
    touched: dict[tuple[int, ...], int] = {}
    for frame, person, subject, other, strength in zip(
        np.asarray(contacts.frame).tolist(),
        np.asarray(contacts.person).tolist(),
        np.asarray(contacts.subject).tolist(),
        np.asarray(contacts.other).tolist(),
        _strength(contacts).tolist(),
        strict=True,
    ):
        if strength > 0.0 and result.names[other] not in planes:
            pair = (person, subject, other)
            touched[pair] = min(frame, touched.get(pair, frame))
    apart = np.zeros(total)
    for p in result.people:
        gap = p.body.joints(p.motion) - p.body.joints(p.recorded)
        apart = np.maximum(apart, np.linalg.norm(gap, axis=2).max(axis=1))
    wanted = [*sorted(touched.values()), total - 1, 0]
    if apart.max() > 1e-3:
        wanted.insert(len(touched), int(apart.argmax()))
    chosen: list[int] = []
    # Two pictures of nearly the same time are redundant.
    near = max(1, total // (4 * count))
    for frame in wanted:
        if len(chosen) < count and all(abs(frame - c) >= near for c in chosen):
            chosen.append(frame)
    while len(chosen) < count:
        ends = sorted({-1, *chosen, total})
        gaps = [(b - a, -a) for a, b in itertools.pairwise(ends)]
        width, start = max(gaps)
        if width < 2:
            break
        low = -start
        if low < 0:  # before the first chosen frame
            chosen.append(0)
        elif low + width >= total:
            chosen.append(total - 1)
        else:
            chosen.append(low + width // 2)
    return sorted(chosen)


def _strength(contacts: Any) -> NDArray[np.float64]:
    """Size of each contact's impulse (n,) [N s]."""
    result: NDArray[np.float64] = np.linalg.norm(
        np.asarray(contacts.impulse, dtype=np.float64).reshape(-1, 3), axis=1
    )
    return result


def caption(result: Result, frame: int) -> tuple[str, str]:
    """Two short lines: the time, and the pairs in contact (strongest first, planes left out)."""
    from halfphysics.geometry.shapes import Plane

    time = f"frame {frame}   {frame / result.fps:.2f} s"
    contacts: Any = result.contacts
    rows = np.flatnonzero(np.asarray(contacts.frame) == frame)
    strength = _strength(contacts)[rows]
    rows, strength = rows[strength > 0.0], strength[strength > 0.0]
    said: list[str] = []
    for row in rows[np.argsort(-strength, kind="stable")]:
        part, other = int(contacts.part[row]), result.names[int(contacts.other[row])]
        static = result.scene.statics.get(other)
        if static is not None and isinstance(static.shape, Plane):
            continue
        if part < 0:
            text = f"{result.names[int(contacts.subject[row])]} : {other}"
        else:
            text = f"{JOINT_NAMES[part].replace('_', ' ')} : {other}"
        if text not in said:
            said.append(text)
    more = f"  +{len(said) - 2}" if len(said) > 2 else ""
    return time, ",  ".join(said[:2]) + more


def save_contact_sheet(
    result: Result,
    path: str | os.PathLike[str],
    frames: Sequence[int] | None = None,
    columns: int = 6,
    size: tuple[int, int] = (300, 340),
    *,
    samples: int = 2,
    threads: int = 1,
    views: Sequence[Camera] | None = None,
) -> Path:
    """Writes a PNG of key frames: simulated body solid, ghost (the reference) translucent blue.

    One direction of view is chosen for all pictures so that body and ghost appear apart and few
    items hide them; a wall that still hides the story is drawn as glass.

    Args:
        result: The result to show.
        path: The PNG to write; whole or not at all.
        frames: Frames to show, negative ones from the end; None picks two rows of key frames.
        columns: Pictures per row.
        size: Width and height of one picture [pixels].
        samples: Anti-aliasing, samples x samples points per pixel, 1 to 4.
        threads: Worker threads; the picture does not depend on it.
        views: Camera of each frame; None chooses as above.

    Returns:
        The path written.

    Raises:
        InputError: No such frame, no columns, an impossible size, or not one view per frame.
        FileError: The file cannot be written.
    """
    from halfphysics.base.atomic import atomic_write

    drawing, picked = _checked(result, frames, columns, size)
    with atomic_write(path) as file:  # refuse an impossible path before rendering
        sheet = _draw(drawing, picked, columns, size, samples, threads, views)
        sheet.save(file, format="PNG")
    return Path(path)


def contact_sheet_png(
    result: Result,
    frames: Sequence[int] | None = None,
    columns: int = 6,
    size: tuple[int, int] = (300, 340),
    *,
    samples: int = 2,
    colors: int = 128,
    views: Sequence[Camera] | None = None,
) -> bytes:
    """The contact sheet as bytes of a PNG with a palette, a third of the size, for embedding.

    Args:
        result, frames, columns, size, samples, views: As for `save_contact_sheet`.
        colors: Number of colours in the palette, 2 to 256.

    Raises:
        InputError: No such frame, no columns, an impossible size or number of colours.
    """
    if not 2 <= colors <= 256:
        raise InputError(f"colors: found {colors}, expected 2 to 256")
    drawing, picked = _checked(result, frames, columns, size)
    sheet = _draw(drawing, picked, columns, size, samples, 1, views)
    # An octree keeps small bright areas, such as a ball or the key's blue; a median cut greys them.
    sheet = sheet.quantize(colors, method=_OCTREE, dither=0)
    data = BytesIO()
    sheet.save(data, format="PNG", optimize=True)
    return data.getvalue()


def _checked(
    result: Result, frames: Sequence[int] | None, columns: int, size: tuple[int, int]
) -> tuple[Drawing, list[int]]:
    """The drawing and the indices of its frames to show."""
    if columns < 1:
        raise InputError(f"columns: found {columns}, expected 1 or more")
    if min(size) < 16:
        raise InputError(f"size: found {size}, expected at least 16 x 16 pixels")
    drawing = Drawing(result)
    if frames is None:
        return drawing, key_frames(result, _ROWS * columns)
    picked = [drawing.check_frame(f) for f in frames]
    if not picked:
        raise InputError("frames: found none, expected at least one frame")
    return drawing, picked


def _draw(
    drawing: Drawing,
    picked: Sequence[int],
    columns: int,
    size: tuple[int, int],
    samples: int,
    threads: int,
    views: Sequence[Camera] | None,
) -> Any:
    """The whole sheet."""
    if views is None:
        views = cameras(drawing, picked, choose_direction(drawing, picked, size), size)
    elif len(views) != len(picked):
        raise InputError(f"views: found {len(views)}, expected {len(picked)}, one for each frame")
    tiles = []
    for frame, camera in zip(picked, views, strict=True):
        faint = glass(drawing.surfaces(frame), camera, size)
        shown = [*drawing.still(faint, frame).values(), *drawing.moving(frame)]
        shown += drawing.edges(camera, size[1], frame)
        look = Look.of(drawing.theme).aimed(camera, drawing.middle)
        tiles.append(render(shown, camera, size, samples=samples, look=look, threads=threads))
    return compose(drawing.result, picked, tiles, columns, size)


def _font(pixels: int) -> Any:
    """Pillow's own font: scalable if Pillow was built with FreeType."""
    from PIL import ImageFont

    return ImageFont.load_default(pixels)


def _bytes(color: Color) -> tuple[int, int, int]:
    r, g, b = (round(255 * c) for c in color)
    return r, g, b


def _fitted(draw: Any, text: str, font: Any, width: int) -> str:
    """The text, cut with an ellipsis if it is wider than `width` pixels."""
    if draw.textlength(text, font=font) <= width:
        return text
    while text and draw.textlength(text + "...", font=font) > width:
        text = text[:-1]
    return text + "..."


def compose(
    result: Result,
    frames: Sequence[int],
    tiles: Sequence[NDArray[np.uint8]],
    columns: int,
    size: tuple[int, int],
) -> Any:
    """One sheet: pictures (each `size`) in rows, text under each, a key at the bottom."""
    from PIL import Image, ImageDraw

    across, down = min(columns, len(tiles)), -(-len(tiles) // columns)
    font = _font(_TEXT)
    line = _TEXT + 5
    cell = (size[0] + _GAP, size[1] + 2 * line + _GAP + 4)
    width = 2 * _MARGIN + across * cell[0] - _GAP
    height = 2 * _MARGIN + down * cell[1] + line
    sheet = Image.new("RGB", (width, height), _PAPER)
    draw = ImageDraw.Draw(sheet)
    for k, (frame, tile) in enumerate(zip(frames, tiles, strict=True)):
        x, y = _MARGIN + k % columns * cell[0], _MARGIN + k // columns * cell[1]
        sheet.paste(Image.fromarray(tile), (x, y))
        for row, (text, ink) in enumerate(
            zip(caption(result, frame), (_INK, _SOFT_INK), strict=True)
        ):
            text = _fitted(draw, text, font, size[0] - 4)
            draw.text((x + 2, y + size[1] + 4 + row * line), text, fill=ink, font=font)
    x, y = _MARGIN + 2, height - _MARGIN - line + 4
    for text, color in (("reference", GHOST), ("simulated", PEOPLE[0])):
        draw.rectangle([x, y + 1, x + _TEXT - 2, y + _TEXT - 1], fill=_bytes(color))
        draw.text((x + _TEXT + 4, y), text, fill=_INK, font=font)
        x += _TEXT + 28 + int(draw.textlength(text, font=font))
    return sheet
