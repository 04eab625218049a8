"""Actors: humans that react.

An `Actor` gives the reference of one person frame by frame, by what it sees. `Clip` plays a
motion, `Mixed` changes between actors, `Person` acts by goals: `WalkTo`, `TurnTo`, `Follow`,
`ReachFor`, `HandOver`, `LookAt`, `SitOn`, `StandUp` and `Wait`. `play` lets them act in a scene.
"""

from __future__ import annotations

from halfphysics.actors.actor import Actor
from halfphysics.actors.clip import Clip
from halfphysics.actors.look_at import LookAt, Wait
from halfphysics.actors.mixed import Mixed
from halfphysics.actors.person import Person
from halfphysics.actors.play import SETTINGS, play
from halfphysics.actors.reach_for import HandOver, ReachFor
from halfphysics.actors.seen import Other, Seen
from halfphysics.actors.sit_on import SitOn, StandUp
from halfphysics.actors.walk_to import Follow, TurnTo, WalkTo

__all__ = [
    "SETTINGS",
    "Actor",
    "Clip",
    "Follow",
    "HandOver",
    "LookAt",
    "Mixed",
    "Other",
    "Person",
    "ReachFor",
    "Seen",
    "SitOn",
    "StandUp",
    "TurnTo",
    "Wait",
    "WalkTo",
    "play",
]
