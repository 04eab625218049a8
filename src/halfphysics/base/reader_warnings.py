"""Warnings of the readers, shown at the line of the caller outside the package."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

from halfphysics.errors import HalfPhysicsWarning

_PACKAGE = str(Path(__file__).resolve().parent.parent)


def warn(message: str) -> None:
    """Warn at the first frame outside the package, however deep the reader is."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, HalfPhysicsWarning, stacklevel=level)
