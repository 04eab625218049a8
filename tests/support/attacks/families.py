"""The families of attack scenes: name -> builder(rng) -> `Attack`.

Each is a way in which contact was, or could have been, slow or leaky: very many triangles near a
body, triangles without an inside, openings narrower than a hand, surfaces that move as told.
"""

from __future__ import annotations

from support.attacks import ground, moving, openings, people, surfaces
from support.attacks.registry import FAMILIES

#: Importing the modules registers their families.
MODULES = (ground, moving, openings, people, surfaces)

__all__ = ["FAMILIES", "MODULES"]
