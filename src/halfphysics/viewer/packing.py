"""Arrays as text in a page."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray


def packed(values: NDArray[Any], kind: str) -> str:
    """An array as deflated base64: the lowest bytes of all numbers, then the second ones, ..."""
    flat = np.ascontiguousarray(values.astype(kind)).reshape(-1, 1)
    return base64.b64encode(zlib.compress(flat.view(np.uint8).T.tobytes(), 6)).decode("ascii")
