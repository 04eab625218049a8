"""What the members of a simulation are called, and the rows that material pairs have for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.scene.material_pairs import PERSON

if TYPE_CHECKING:
    from halfphysics.scene.scene import Scene


@dataclass(frozen=True)
class Names:
    """Names of a scene's items and of people.

    Attributes:
        everything: What contacts refer to: statics, objects, links, people, in this order.
        people: The people's names.
        owner: Name of an articulated object's link -> name of that object in the scene.
        parts: "person/JOINT" of the parts whose friction or ignoring the scene sets apart.
    """

    everything: tuple[str, ...]
    people: tuple[str, ...]
    owner: Mapping[str, str]
    parts: tuple[str, ...]

    @staticmethod
    def of(scene: Scene, people: int) -> Names:
        """Names of a scene with so many people.

        Raises:
            InputError: An item of the scene is named like a person.
        """
        whole = tuple(f"{PERSON}{i}" for i in range(people)) if people > 1 else (PERSON,) * people
        owner = {n: item.name for item in scene.articulated.values() for n in item.link_names}
        everything = (*scene.statics, *scene.objects, *owner, *whole)
        if len(set(everything)) < len(everything):
            raise InputError(
                f"scene: a static or object is named like a person ({', '.join(whole)}); rename it"
            )
        return Names(everything, whole, owner, parts_set_apart(scene))

    def index(self, name: str) -> int:
        """Index of a name in `everything`."""
        return self._indices[name]

    @cached_property
    def _indices(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.everything)}

    def row_of_part(self, person: str, joint: int) -> int:
        """The row that a person's part has among material pairs: its own, or the person's."""
        part = f"{PERSON}/{JOINT_NAMES[joint]}"
        if part in self.parts:
            return len(self.everything) + self.parts.index(part)
        return self.index(person)

    @property
    def in_scene(self) -> list[str]:
        """Of every row of material pairs what the scene calls it."""
        people = set(self.people)
        rows = [PERSON if n in people else self.owner.get(n, n) for n in self.everything]
        return [*rows, *self.parts]


def parts_set_apart(scene: Scene) -> tuple[str, ...]:
    """ "person/JOINT" of the parts that a scene names in a pair of its own, sorted."""
    pairs = [(a, b) for a, b, _ in scene.friction_pairs] + [*scene.ignored_pairs]
    ends = {end for pair in pairs for end in pair}
    return tuple(sorted(end for end in ends if end.startswith(f"{PERSON}/")))
