"""Actors: humans that react.

An `Actor` gives the reference of one person frame by frame, by what it sees.
"""

from __future__ import annotations

from halfphysics.actors.actor import Actor
from halfphysics.actors.clip import Clip
from halfphysics.actors.seen import Seen

__all__ = ["Actor", "Clip", "Seen"]
