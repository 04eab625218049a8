"""The table of families; modules of builders add to it by `family`."""

from __future__ import annotations

FAMILIES = {}


def family(build):
    """Registers a builder(rng) -> `Attack` by its name."""
    FAMILIES[build.__name__] = build
    return build
