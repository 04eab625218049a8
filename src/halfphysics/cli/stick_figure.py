"""A person as a stick figure of text: eight dots to a character, for a look in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from halfphysics.motion.skeleton import JOINT_INDEX, PARENTS

Array = NDArray[np.float64]

#: Joints that are drawn: fingers, jaw and eyes are too small.
_DRAWN = range(1, 22)
#: Height of a picture [lines], and metres that it shows at least.
ROWS, _LEAST = 16, 1.9
#: Dots of a character, by row and column, as bits of the braille patterns from U+2800 on.
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_BLANK = 0x2800
#: The head is a ring of this size about so far beyond its joint, along the neck [m].
_HEAD, _BEYOND = 0.1, 0.1
# Dots along a bone [1/dot]: none is missed.
_FINE = 3


def stick_figures(people: Sequence[Array], *, captions: Sequence[str]) -> list[str]:
    """Stick figures side by side, all to one scale, up is up.

    Args:
        people: Joints (55, 3) [m] of each figure, z up; each is seen from the front by the line of
            its shoulders, and stands over its own middle.
        captions: A word under each.

    Returns:
        Lines of text. The dotted line is z = 0, where it is in the picture.
    """
    flat = [_from_front(joints) for joints in people]
    low = min(float(points[:, 1].min()) for points in flat)
    high = max(float(np.max([*points[:, 1], *_ring(points)[:, 1]])) for points in flat)
    if -0.5 < low < 0.5:
        low = min(low, 0.0)
    tall = max(high - low, _LEAST)
    dots = 4 * ROWS - 1
    scale = (dots - 1) / tall
    pictures = []
    for points, caption in zip(flat, captions, strict=True):
        half = max(float(np.abs(points[:, 0]).max()), 0.25)
        columns = int(np.ceil((2.0 * half * scale + 3.0) / 2.0))
        columns = max(columns, len(caption) + 1)
        canvas = np.zeros((4 * ROWS, 2 * columns), dtype=bool)
        if low <= 0.0 <= low + tall:
            canvas[dots - round((0.0 - low) * scale), ::2] = True
        for joint in _DRAWN:
            _line(canvas, points[PARENTS[joint]], points[joint], low, scale, dots)
        for a, b in pairwise(_ring(points)):
            _line(canvas, a, b, low, scale, dots)
        pictures.append([*_text(canvas), caption.center(columns)])
    return ["  ".join(line).rstrip() for line in zip(*pictures, strict=True)]


def _from_front(joints: Array) -> Array:
    """Joints (55, 2): right to left of the person, and up; about the middle of the hips."""
    across = joints[JOINT_INDEX["left_shoulder"]] - joints[JOINT_INDEX["right_shoulder"]]
    across = across + joints[JOINT_INDEX["left_hip"]] - joints[JOINT_INDEX["right_hip"]]
    level = across * [1.0, 1.0, 0.0]
    size = float(np.linalg.norm(level))
    level = level / size if size > 1e-6 else np.array([1.0, 0.0, 0.0])
    # Seen from the front a person's left is to the right.
    points = np.stack([(joints - joints[0]) @ level, joints[:, 2]], axis=1)
    points[:, 0] -= 0.5 * (points[:, 0].min() + points[:, 0].max())
    return points


def _ring(points: Array) -> Array:
    """The head, as the corners (13, 2) of a ring."""
    neck, head = points[JOINT_INDEX["neck"]], points[JOINT_INDEX["head"]]
    along = (head - neck) / max(float(np.linalg.norm(head - neck)), 1e-6)
    turn = np.linspace(0.0, 2.0 * np.pi, 13)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    result: Array = head + _BEYOND * along + _HEAD * ring
    return result


def _line(
    canvas: NDArray[np.bool_], a: Array, b: Array, low: float, scale: float, dots: int
) -> None:
    count = max(2, int(_FINE * scale * float(np.linalg.norm(b - a))))
    points = a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)
    column = np.round(points[:, 0] * scale + canvas.shape[1] / 2.0).astype(int)
    row = np.round(dots - (points[:, 1] - low) * scale).astype(int)
    canvas[np.clip(row, 0, len(canvas) - 1), np.clip(column, 0, canvas.shape[1] - 1)] = True


def _text(canvas: NDArray[np.bool_]) -> list[str]:
    rows, columns = canvas.shape[0] // 4, canvas.shape[1] // 2
    cells = canvas.reshape(rows, 4, columns, 2).transpose(0, 2, 1, 3)
    codes = _BLANK + (cells * _BITS).sum(axis=(2, 3))
    return ["".join(chr(code) for code in line) for line in codes.tolist()]
