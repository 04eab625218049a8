"""The solver's own contacts with the distance of their two sides at the frame itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from halfphysics.metrics.part_distance import Poses
from halfphysics.results.table import Ints, Table

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class SolverContacts(Table):
    """Contacts during (t-1, t], one row per pair: columns of one length n, by frame.

    Attributes:
        frame: The frame t (n,).
        person: Index of the person (n,); -1 where an object touches a static or an object.
        part: Index into `JOINT_NAMES` (n,); -1 where `person` is.
        object: Index of the touched item into the names (n,).
        position: Position of the contact in the world (n, 3) [m].
        normal: Unit vector from the touched item into the part (n, 3).
        distance: Distance of the two sides at frame t (n,) [m]; 0 or less if they overlap, inf
            beyond 0.1 m: after a bounce they are apart again.
        impulse: Impulse on the part, summed over (t-1, t] (n, 3) [N s].
        subject: Index into the names of the object in place of a part (n,), -1 for a person.
        other_part: Index into `JOINT_NAMES` of the other person's part (n,), else -1.
    """

    NAME: ClassVar[str] = "contacts"
    VECTORS: ClassVar[frozenset[str]] = frozenset({"position", "normal", "impulse"})
    NUMBERS: ClassVar[frozenset[str]] = frozenset({"distance"})
    ENDLESS: ClassVar[frozenset[str]] = frozenset({"distance"})

    frame: Ints
    person: Ints
    part: Ints
    object: Ints
    position: Array
    normal: Array
    distance: Array
    impulse: Array
    subject: Ints
    other_part: Ints

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The columns in small types: whole numbers in 8 to 32 bits, the rest float32."""
        kinds = {"frame": np.int32, "object": np.int16, "subject": np.int16, "person": np.int16}
        small = {"part": np.int8, "other_part": np.int8}
        return {
            name: np.asarray(getattr(self, name), {**kinds, **small}.get(name, np.float32))
            for name in self.columns()
        }


def solver_contacts(result: Result) -> SolverContacts:
    """The solver's contacts of a result."""
    contacts = result.contacts
    rows = np.arange(len(contacts))
    poses = Poses(result, [p.motion for p in result.people], result.objects)
    return SolverContacts(
        frame=contacts.frame,
        person=contacts.person,
        part=contacts.part,
        object=contacts.other,
        position=contacts.position,
        normal=contacts.normal,
        distance=poses.distances(rows, contacts.frame),
        impulse=contacts.impulse,
        subject=contacts.subject,
        other_part=contacts.other_part,
    )
