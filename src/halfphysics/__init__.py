"""halfphysics: give a kinematic human a body."""

from __future__ import annotations

__version__ = "0.1.0"
