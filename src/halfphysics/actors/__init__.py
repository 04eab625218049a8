"""Actors: humans that react.

An `Actor` gives the reference of one person frame by frame, by what it sees.
"""

from __future__ import annotations

from halfphysics.actors.actor import Actor
from halfphysics.actors.clip import Clip
from halfphysics.actors.person import Person
from halfphysics.actors.seen import Other, Seen
from halfphysics.actors.walk_to import Follow, TurnTo, WalkTo

__all__ = ["Actor", "Clip", "Follow", "Other", "Person", "Seen", "TurnTo", "WalkTo"]
