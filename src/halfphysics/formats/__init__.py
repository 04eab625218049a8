"""Files: motions and scenes in and out. `registry` knows the formats.

Its names are imported when first used: what is below (a cache, a mesh reader) serves the core,
which the formats stand on.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics.formats.format import Format, Options, Source
    from halfphysics.formats.registry import (
        FORMATS,
        identify,
        load_motion,
        load_sequence,
        losses,
        save_motion,
        unknown,
        writer_of,
    )

__all__ = [
    "FORMATS",
    "Format",
    "Options",
    "Source",
    "identify",
    "load_motion",
    "load_sequence",
    "losses",
    "save_motion",
    "unknown",
    "writer_of",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.registry"), name)
