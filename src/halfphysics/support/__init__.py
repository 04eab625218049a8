"""Support: what holds a person up, and what nothing could supply. See docs/support.md."""

from __future__ import annotations

from halfphysics.support.estimate import estimate
from halfphysics.support.support import Pressure, Support

__all__ = ["Pressure", "Support", "estimate"]
