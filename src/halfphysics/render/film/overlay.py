"""Text on a film: time, labels and colour key, on small bright plates."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Color

Picture = NDArray[np.uint8]
Patch = NDArray[np.uint8]  # (h, w, 4): colour and opacity
Place = tuple[int, int, int, int]  # left, top, right, bottom [pixels]

_INK, _PLATE, _OPACITY = (34, 38, 46), (255, 255, 255), 0.82
_LEAST_TEXT = 10  # [pixels]
_FIGURE_SPACE = "\u2007"  # as wide as a digit
# Fonts for letters that Pillow's own font (English) lacks, if they are installed.
_OTHER_FONTS = ("DejaVuSans.ttf", "Arial Unicode.ttf", "Arial.ttf", "LiberationSans-Regular.ttf")


class Overlay:
    """The text on every picture of a film.

    Args:
        size: Width and height of the picture [pixels].
        views: Places of the views in it.
        labels: Text for the views, none or one each.
        times: Times of the pictures [s]; empty: the time is not shown.
        speed: Speed of the film, written beside the time if it is not 1.
        key: Labels of the key with their colours.
    """

    def __init__(
        self,
        size: tuple[int, int],
        views: Sequence[Place],
        *,
        labels: Sequence[str] = (),
        times: Sequence[float] = (),
        speed: float = 1.0,
        key: Sequence[tuple[str, Color]] = (),
    ) -> None:
        width = min(right - left for left, _, right, _ in views)
        height = min(bottom - top for _, top, _, bottom in views)
        self._text = max(_LEAST_TEXT, round(min(0.034 * height, 0.045 * width)))
        self._gap = max(3, round(0.6 * self._text))
        self._times = times
        self._speed = "" if speed == 1.0 else f"   speed {speed:g}"
        self._still: list[tuple[int, int, Patch]] = []
        for (left, top, right, _), label in zip(views, labels, strict=False):
            if label:
                patch = _plate(_fitted(label, self._text, right - left - 4 * self._gap), self._text)
                self._still.append((left + self._gap, top + self._gap, patch))
        stamp = self._stamp(max(times)).shape[1] if times else 0
        if key:
            patch = _key(key, self._text)
            left = size[0] - self._gap - patch.shape[1]
            # If there is not enough space for both, show only the time.
            if left >= stamp + 2 * self._gap:
                self._still.append((left, size[1] - self._gap - patch.shape[0], patch))

    def _stamp(self, time: float) -> Patch:
        width = len(f"{max(self._times):.2f}")
        number = f"{time:.2f}".rjust(width, _FIGURE_SPACE)
        return _plate(f"{number} s{self._speed}", self._text)

    def draw(self, picture: Picture, index: int) -> None:
        """Writes on picture number `index`, in place."""
        for left, top, patch in self._still:
            _blend(picture, left, top, patch)
        if self._times:
            patch = self._stamp(self._times[index])
            _blend(picture, self._gap, picture.shape[0] - self._gap - patch.shape[0], patch)


def _blend(picture: Picture, left: int, top: int, patch: Patch) -> None:
    """Lays a patch over a picture; the part outside is cut off."""
    top, left = max(top, 0), max(left, 0)
    part = picture[top : top + patch.shape[0], left : left + patch.shape[1]]
    wide = patch[: part.shape[0], : part.shape[1]].astype(np.uint32)
    alpha = wide[..., 3:]
    part[:] = (wide[..., :3] * alpha + part * (255 - alpha) + 127) // 255


@cache
def _fonts(pixels: int) -> tuple[Any, ...]:
    """Pillow's own font, then installed fonts."""
    from PIL import ImageFont

    found: list[Any] = [ImageFont.load_default(pixels)]
    for name in _OTHER_FONTS:
        try:
            found.append(ImageFont.truetype(name, pixels))
        except OSError:
            continue  # not on this machine
    return tuple(found)


@cache
def _font(letter: str, pixels: int) -> Any:
    """The first font that has this letter; if none has it, the first."""
    if letter.isspace():
        return _fonts(pixels)[0]
    for font in _fonts(pixels):
        if bytes(font.getmask(letter)) != bytes(font.getmask("\uffff")):
            return font
    return _fonts(pixels)[0]


@cache
def _step(letter: str, pixels: int) -> float:
    """Width of a letter [pixels]; all digits and the figure space have the same width."""
    if letter.isdigit() or letter == _FIGURE_SPACE:
        return max(float(_font(d, pixels).getlength(d)) for d in "0123456789")
    return float(_font(letter, pixels).getlength(letter))


def _fitted(text: str, pixels: int, width: int) -> str:
    """The text, cut with an ellipsis if it is wider than `width` pixels."""
    if sum(_step(c, pixels) for c in text) <= width:
        return text
    while text and sum(_step(c, pixels) for c in text + "...") > width:
        text = text[:-1]
    return text + "..."


def _plate(text: str, pixels: int, before: int = 0) -> Patch:
    """Dark text on a bright plate with round corners, and space `before` it [pixels]."""
    from PIL import Image, ImageDraw

    pad = round(0.5 * pixels)
    width = before + 2 * pad + int(np.ceil(sum(_step(c, pixels) for c in text)))
    height = round(1.75 * pixels)
    ink = Image.new("L", (width, height))
    draw = ImageDraw.Draw(ink)
    x = float(pad + before)
    for letter in text:
        if not letter.isspace():  # a font without the figure space draws a box for it
            draw.text((x, 0.5 * height), letter, fill=255, font=_font(letter, pixels), anchor="lm")
        x += _step(letter, pixels)
    # Smooth round corners: draw them large, then scale down.
    plate = Image.new("L", (4 * width, 4 * height))
    corner = 4 * round(0.45 * pixels)
    ImageDraw.Draw(plate).rounded_rectangle(
        (0, 0, 4 * width - 1, 4 * height - 1), radius=corner, fill=255
    )
    shape = np.asarray(plate.resize((width, height), Image.Resampling.BOX), dtype=np.float64) / 255
    cover = np.asarray(ink, dtype=np.float64)[..., None] / 255
    color = (1.0 - cover) * np.array(_PLATE) + cover * np.array(_INK)
    opacity = shape[..., None] * (_OPACITY + (1.0 - _OPACITY) * cover)
    result: Patch = np.rint(np.concatenate([color, 255 * opacity], axis=2)).astype(np.uint8)
    return result


def _key(entries: Sequence[tuple[str, Color]], pixels: int) -> Patch:
    """A plate with a coloured square before each label."""
    square, room = round(0.8 * pixels), round(1.3 * pixels)
    plates = []
    for words, color in entries:
        plate = _plate(words, pixels, before=room)
        left, top = round(0.5 * pixels), (plate.shape[0] - square) // 2
        plate[top : top + square, left : left + square] = (*(round(255 * c) for c in color), 255)
        plates.append(plate)
    gap = np.zeros((plates[0].shape[0], round(0.4 * pixels), 4), dtype=np.uint8)
    joined = [plates[0]]
    for plate in plates[1:]:
        joined += [gap, plate]
    return np.concatenate(joined, axis=1)
