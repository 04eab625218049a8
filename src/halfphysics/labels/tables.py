"""Contact labels of a result in the layouts of docs/labels.md.

Ids are those of GRAB: 0 without a contact, else 1 plus the part's index into `JOINT_NAMES`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.short_repr import short_repr
from halfphysics.base.validation import is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.labels.item_solids import item_solids
from halfphysics.labels.proximity import Near, Target, near
from halfphysics.labels.sampling import ObjectSurface
from halfphysics.labels.solver_contacts import SolverContacts
from halfphysics.motion.skeleton import JOINT_INDEX, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS

if TYPE_CHECKING:
    from halfphysics.results.result import Result
    from halfphysics.results.soft_contacts import SoftContacts

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ids = NDArray[np.int8]

#: Of `hands_feet`: the parts of each hand (wrist and fingers) and foot (ankle and toes).
LEFT_HAND = (JOINT_INDEX["left_wrist"], *LEFT_HAND_JOINTS)
RIGHT_HAND = (JOINT_INDEX["right_wrist"], *RIGHT_HAND_JOINTS)
LEFT_FOOT = (JOINT_INDEX["left_ankle"], JOINT_INDEX["left_foot"])
RIGHT_FOOT = (JOINT_INDEX["right_ankle"], JOINT_INDEX["right_foot"])


@dataclass(frozen=True, kw_only=True, eq=False)
class PersonLabels:
    """Contact labels of one person.

    Attributes:
        name: As in `Result.names`.
        vertex_part: Index into `JOINT_NAMES` of every vertex's part (Vb,): its largest weight.
        body_near: For every object, the vertices of the skin that touch it.
        object_near: For every object, its vertices that touch the skin.
        scene_near: The vertices of the skin that touch static geometry, once per frame, with the
            minimum distance.
        human_parts: Parts that touch an object (T, 55): by a vertex, or by an impulse of the solver
            during (t-1, t].
        scene_parts: The same for static geometry: statics, and links that no joint moves.
        people_parts: Parts with an impulse from another person, or in self-contact (T, 55).
        force: Force on every part (T, 55, 3) [N]: mean over (t-1, t], world.
        force_objects: The part of that force that objects exert (T, 55, 3) [N].
    """

    name: str
    vertex_part: NDArray[np.int8]
    body_near: tuple[Near, ...]
    object_near: tuple[Near, ...]
    scene_near: Near
    human_parts: Bools
    scene_parts: Bools
    people_parts: Bools
    force: Array
    force_objects: Array

    __repr__ = short_repr

    def body(self, item: int = 0) -> Ids:
        """Ids (T, Vb) of the skin's vertices: their part's id if they touch an object.

        Raises:
            InputError: No such object; without objects the first one touches nothing.
        """
        count = len(self.body_near)
        if not (is_whole(item, least=0, plain=False) and item < max(count, 1)):
            raise InputError(
                f"labels: found object {shown(item)}, expected one of {count} objects, by its index"
            )
        rows = self.body_near[item] if self.body_near else Near.joined([])
        return self._ids(rows)

    @property
    def scene(self) -> Ids:
        """Ids (T, Vb) of the skin's vertices: their part's id if they touch static geometry."""
        return self._ids(self.scene_near)

    @property
    def hands_feet(self) -> Bools:
        """Whether (T, 4) left, right hand touch an object, left, right foot static geometry."""
        return np.stack(
            [
                self.human_parts[:, LEFT_HAND].any(axis=1),
                self.human_parts[:, RIGHT_HAND].any(axis=1),
                self.scene_parts[:, LEFT_FOOT].any(axis=1),
                self.scene_parts[:, RIGHT_FOOT].any(axis=1),
            ],
            axis=1,
        )

    def _ids(self, rows: Near) -> Ids:
        ids = np.zeros((len(self.human_parts), len(self.vertex_part)), dtype=np.int8)
        ids[rows.frame, rows.vertex] = self.vertex_part[rows.vertex] + 1
        return ids


@dataclass(frozen=True, kw_only=True, eq=False)
class ContactLabels:
    """Contact labels of all people in a result.

    Attributes:
        threshold_m: Largest distance of a contact [m].
        reach: Largest distance for `skin_near` and `object_near` [m].
        fps: Frames per second.
        people: One entry per person.
        objects: Moving items in the scene's order, links of articulated objects one by one
            ("NAME/LINK").
        names: Names to which `contacts` refers: statics, objects, people.
        contacts: The solver's contacts.
    """

    threshold_m: float
    reach: float
    fps: float
    people: tuple[PersonLabels, ...]
    objects: tuple[ObjectSurface, ...]
    names: tuple[str, ...]
    contacts: SolverContacts
    result: Result = field(repr=False)

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.people[0].human_parts)

    @property
    def body(self) -> Ids:
        """Of the first person and object: ids (T, Vb), see `PersonLabels.body`."""
        return self.people[0].body()

    @property
    def object(self) -> Ids:
        """Of the first person and object: ids (T, Vo), see `object_ids`."""
        return self.object_ids()

    @property
    def hands_feet(self) -> Bools:
        """Of the first person (T, 4), see `PersonLabels.hands_feet`."""
        return self.people[0].hands_feet

    def object_ids(self, person: int = 0, item: int = 0) -> Ids:
        """Ids (T, Vo) of an object's vertices: the id of the part that they touch.

        Raises:
            InputError: No such person or object; without objects the first one has no vertices.
        """
        self.check(person, item, least=1)
        owner = self.people[person]
        count = len(self.objects[item].vertices) if self.objects else 0
        ids = np.zeros((len(self), count), dtype=np.int8)
        if self.objects:
            rows = owner.object_near[item]
            ids[rows.frame, rows.vertex] = owner.vertex_part[rows.nearest] + 1
        return ids

    def skin_near(self, within: float, person: int = 0, item: int = 0) -> Near:
        """Vertices of a person's skin at most `within` from an object, with their distances [m].

        Raises:
            InputError: Farther than `reach`, or no such person or object.
        """
        within = number(within, "within", least=0.0, unit="m")
        if (within, True) in self._found:  # it has the skin's vertices too
            return self._near(within, person, item, True)[0].within(within)
        return self._near(within, person, item, False)[0].within(within)

    def object_near(self, within: float, person: int = 0, item: int = 0) -> Near:
        """Vertices of an object at most `within` from a person's skin, with their distances [m].

        Raises:
            InputError: Farther than `reach`, or no such person or object.
        """
        return self._near(within, person, item, True)[1].within(within)

    def arrays(self, *, scene: bool = False) -> dict[str, NDArray[Any]]:
        """The arrays of a contact.npz: docs/labels.md has every key.

        The first person's labels with the first object are under the plain keys; another object's
        have "/NAME" after the key, another person's "PERSON/" before it.

        Args:
            scene: Include "scene", the ids (T, Vb) of vertices that touch statics.
        """
        found: dict[str, NDArray[Any]] = {
            "threshold_m": np.array(self.threshold_m),
            "fps": np.array(self.fps),
            "people": np.array([p.name for p in self.people], dtype=str),
            "objects": np.array([o.name for o in self.objects], dtype=str),
            "names": np.array(self.names, dtype=str),
        }
        for k, item in enumerate(self.objects):
            found[_key("object_vertices", item.name, k)] = item.vertices.astype(np.float32)
            found[_key("object_faces", item.name, k)] = item.faces
        for i, owner in enumerate(self.people):
            mine: dict[str, NDArray[Any]] = {}
            for k, name in enumerate([o.name for o in self.objects] or [""]):
                mine[_key("body", name, k)] = owner.body(k)
                mine[_key("object", name, k)] = self.object_ids(i, k)
            if scene:
                mine["scene"] = owner.scene
            mine |= {
                "human_parts": owner.human_parts,
                "scene_parts": owner.scene_parts,
                "people_parts": owner.people_parts,
                "hands_feet": owner.hands_feet,
                "force": owner.force.astype(np.float32),
                "force_objects": owner.force_objects.astype(np.float32),
            }
            found |= {key if i == 0 else f"{owner.name}/{key}": mine[key] for key in mine}
        found |= {f"contacts/{key}": value for key, value in self.contacts.arrays().items()}
        if (soft := self.result.soft_contacts) is not None:
            found |= {f"soft/{key}": value for key, value in _small(soft).items()}
        return found

    def check(self, person: int, item: int, *, least: int = 0) -> None:
        """Refuse a person or an object that is not there.

        Args:
            person: Index into `people`.
            item: Index into `objects`.
            least: So many objects are taken to be there.

        Raises:
            InputError: It is not.
        """
        for index, count in ((person, len(self.people)), (item, max(len(self.objects), least))):
            if not (is_whole(index, least=0, plain=False) and index < count):
                names = ", ".join(f"{k}: {one.name}" for k, one in enumerate(self.objects))
                raise InputError(
                    f"labels: found person {shown(person)} and object {shown(item)}, expected one "
                    f"of {len(self.people)} people and of {len(self.objects)} objects, by their "
                    f"index ({names or 'none'})"
                )

    def _near(self, within: float, person: int, item: int, both: bool) -> tuple[Near, Near]:
        """Vertices near each other, of the skin alone or of `both`; cached."""
        self.check(person, item)
        within = number(within, "within", least=0.0, unit="m")
        if within <= self.threshold_m:
            owner = self.people[person]
            return owner.body_near[item], owner.object_near[item]
        if within > self.reach:
            raise InputError(
                f"within: found {within:g} m, expected at most {self.reach:g} m. Ask for more when "
                f"the labels are made: contact_labels(result, reach={within:g})"
            )
        if (within, both) not in self._found:
            result = self.result
            solids = {one.name: one for one in item_solids(result.scene, result.objects)}
            targets = [Target(solids[o.name], within, o if both else None) for o in self.objects]
            people = [near(owner.body, owner.motion, targets) for owner in result.people]
            self._found[within, both] = people
        return self._found[within, both][person][item]

    @cached_property
    def _found(self) -> dict[tuple[float, bool], list[list[tuple[Near, Near]]]]:
        return {}


def _small(soft: SoftContacts) -> dict[str, NDArray[Any]]:
    """Columns in small types: whole numbers in 8 to 32 bits, the rest float32."""
    kinds: dict[str, Any] = {"frame": np.int32, "layer": np.int16, "other": np.int16}
    kinds |= {"part": np.int8, "vertex": np.int32}
    return {
        name: np.asarray(getattr(soft, name), kinds.get(name, np.float32))
        for name in soft.columns()
    }


def _key(key: str, name: str, index: int) -> str:
    return key if index == 0 else f"{key}/{name}"
