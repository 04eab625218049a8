"""What a person of a result was among: enough to say what acted on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from halfphysics.base.short_repr import short_repr
from halfphysics.results.contacts import Contacts
from halfphysics.results.deferred import Deferred

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class Surroundings:
    """The scene, the motion of its objects, and contacts; of no person's motion.

    Attributes:
        scene: The simulated scene.
        tracks: Poses of objects and links by name: `Result.objects`.
        names: `Result.names`: statics, objects, people.
        contacts: `Result.contacts`; None: there was no simulation.
        person, people: Index of the person, and how many there are.
    """

    scene: Deferred[Scene] = Deferred()
    tracks: Mapping[str, Any]
    names: tuple[str, ...]
    contacts: Contacts | None
    person: int = 0
    people: int = 1

    __repr__ = short_repr

    @property
    def first_person(self) -> int:
        """Index into `names` of the first person."""
        return len(self.names) - self.people
