"""Clips beside each other as an animated WebP, which GitHub shows where it stands in a document."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

#: Time that the last picture stays [ms].
PAUSE = 1000


def save_side_by_side(
    columns: Sequence[Sequence[np.ndarray]], path: Path, *, fps: float, quality: int
) -> None:
    """Write clips of one number of pictures (h, w, 3) and one height beside each other."""
    pictures = [Image.fromarray(np.concatenate(row, axis=1)) for row in zip(*columns, strict=True)]
    pictures[0].save(
        path,
        save_all=True,
        append_images=pictures[1:],
        duration=[round(1000 / fps)] * (len(pictures) - 1) + [PAUSE],
        loop=0,
        quality=quality,
        method=6,
    )
