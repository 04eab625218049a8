"""Readers and writers of motion, scene and result files. `registry` lists the formats.

Names are imported when first used: importing one module, such as `loading`, loads no format.
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
        unknown,
    )
    from halfphysics.formats.saving import files_of, losses, save_motion, save_people, writer_of

__all__ = [
    "FORMATS",
    "Format",
    "Options",
    "Source",
    "files_of",
    "identify",
    "load_motion",
    "load_sequence",
    "losses",
    "save_motion",
    "save_people",
    "unknown",
    "writer_of",
]

_SAVING = {"files_of", "losses", "save_motion", "save_people", "writer_of"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = "saving" if name in _SAVING else "registry"
    return getattr(importlib.import_module(f"{__name__}.{module}"), name)
