"""Sweeps: every clip of a library times masses, frictions, shapes, settings: docs/sweeps.md.

`plan` reads what is wanted, `variants` computes from a number which simulation it is, `read` gives
the samples of what was made. Names are imported when first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics.sweep.description import describe
    from halfphysics.sweep.plan import Plan
    from halfphysics.sweep.reading import read
    from halfphysics.sweep.variants import Variant, Variants

__all__ = ["Plan", "Variant", "Variants", "describe", "read"]

_MODULES = {
    "Plan": "plan",
    "Variant": "variants",
    "Variants": "variants",
    "describe": "description",
    "read": "reading",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
