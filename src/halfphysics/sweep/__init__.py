"""Sweeps: every clip of a library times masses, frictions, shapes, settings: docs/sweeps.md.

`plan` reads what is wanted, `variants` computes from a number which simulation it is, `read` gives
the samples of what was made. Names are imported when first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfphysics.sweep.plan.description import describe
    from halfphysics.sweep.plan.plan import Plan
    from halfphysics.sweep.plan.variants import Variant, Variants
    from halfphysics.sweep.store.reading import read

__all__ = ["Plan", "Variant", "Variants", "describe", "read"]

_MODULES = {
    "Plan": "plan.plan",
    "Variant": "plan.variants",
    "Variants": "plan.variants",
    "describe": "plan.description",
    "read": "store.reading",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
