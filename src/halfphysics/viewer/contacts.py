"""Contacts of a frame in the scene: points, and arrows whose length shows the force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.rasterizer import Color
from halfphysics.viewer.batches import Arrows, Batch, Copies, ball

if TYPE_CHECKING:
    from halfphysics.results.contacts import Contacts
    from halfphysics.results.result import Result
    from halfphysics.simulation.core_rows import ContactRows
    from halfphysics.viewer.stage import Stage

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Kind:
    """A kind of contact: the label and colour of its points and arrows."""

    label: str
    color: Color


#: Kinds by number: contacts of a person with statics, objects, people; contacts of objects only.
KINDS: tuple[Kind, ...] = (
    Kind("on a person, by the scene", (0.05, 0.48, 0.22)),
    Kind("on a person, by an object", (0.76, 0.05, 0.48)),
    Kind("on a person, by a person", (0.38, 0.16, 0.76)),
    Kind("on an object", (0.25, 0.31, 0.38)),
)
SCENE, OBJECT, PERSON, NO_PERSON = range(4)

#: Length of an arrow [m]: `SHORTEST` up to 1 N, `TENFOLD` more for ten times the force, up to
#: `LARGEST` [N], so that 3 N on a finger and 600 N on a foot are both visible.
SHORTEST, TENFOLD, LARGEST = 0.06, 0.08, 1e4

_POINT = 0.011  # radius [m]


def arrow_lengths(force: Array) -> Array:
    """Lengths of arrows (n,) [m] for forces (n,) [N], logarithmic: see `SHORTEST`."""
    return SHORTEST + TENFOLD * np.log10(np.clip(force, 1.0, LARGEST))


@dataclass(frozen=True, kw_only=True, eq=False)
class FrameContacts:
    """The contacts of one frame.

    Attributes:
        rows: Rows of `Result.contacts` (n,).
        kind: Index into `KINDS` (n,).
        position: World position (n, 3) [m].
        force: Force on the part: impulse over the length of the frame (n, 3) [N].
    """

    rows: Ints
    kind: Ints
    position: Array
    force: Array

    def arrows(self) -> Array:
        """Start and end of the arrows of the contacts with a force (m, 2, 3) [m]."""
        size = np.linalg.norm(self.force, axis=1)
        some = size > 0.0
        along = self.force[some] / size[some, None] * arrow_lengths(size[some])[:, None]
        start = self.position[some]
        return np.stack([start, start + along], axis=1)

    def of(self, kind: int) -> FrameContacts:
        """The contacts of one kind."""
        keep = self.kind == kind
        return FrameContacts(
            rows=self.rows[keep],
            kind=self.kind[keep],
            position=self.position[keep],
            force=self.force[keep],
        )


class ContactSource(Protocol):
    """Contacts by frame.

    Attributes:
        kind: Kind of each possible contact (n,), an index into `KINDS`.
    """

    kind: Ints

    def at(self, frame: int) -> FrameContacts:
        """The contacts of (frame - 1, frame]."""


class ContactFrames:
    """A result's contacts by frame."""

    def __init__(self, result: Result) -> None:
        contacts = result.contacts
        self._position = np.asarray(contacts.position, dtype=np.float64)
        self._force = np.asarray(contacts.impulse, dtype=np.float64) * result.fps
        self.kind: Ints = kinds(result)
        self._first = np.searchsorted(contacts.frame, np.arange(len(result.motion) + 1))

    def at(self, frame: int) -> FrameContacts:
        """The contacts of (frame - 1, frame]."""
        rows = np.arange(self._first[frame], self._first[frame + 1])
        return FrameContacts(
            rows=rows,
            kind=self.kind[rows],
            position=self._position[rows],
            force=self._force[rows],
        )


def kinds(result: Result) -> Ints:
    """Kind of each contact of a result (n,), an index into `KINDS`."""
    count = len(result.names), len(result.objects), len(result.people)
    return kinds_of(result.contacts, *count)


def kinds_of(contacts: Contacts | ContactRows, names: int, objects: int, persons: int) -> Ints:
    """As `kinds`, from the numbers of all names, of objects and of people among the names."""
    people = names - persons
    objects = people - objects
    other = np.asarray(contacts.other)
    kind = np.select([other < objects, other < people], [SCENE, OBJECT], PERSON)
    return np.where(np.asarray(contacts.person) < 0, NO_PERSON, kind)


class ContactNodes:
    """Points and arrows of one result: two nodes per kind, for any number of contacts.

    Args:
        server: The viser server.
        stage: The stage of the result; it calls `show` from then on.
        frames: Other contacts by frame than the result's; None: the result's.

    Attributes:
        frames: The contacts.
        points, arrows: Nodes by kind, for the kinds that occur.
    """

    def __init__(self, server: Any, stage: Stage, frames: ContactSource | None = None) -> None:
        self.frames = ContactFrames(stage.drawing.result) if frames is None else frames
        self.points: dict[int, Copies] = {}
        self.arrows: dict[int, Arrows] = {}
        self._visible = True
        self._frame = -1
        for kind in np.unique(self.frames.kind).tolist():
            color = KINDS[kind].color
            self.points[kind] = Copies(
                server, stage.path(f"contact/point/{kind}"), ball(_POINT), color
            )
            self.arrows[kind] = Arrows(server, stage.path(f"contact/arrow/{kind}"), color)
        stage.followers.append(self.show)

    @property
    def visible(self) -> bool:
        """Whether contacts are drawn. If not, nothing is sent."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        if visible and self._frame >= 0:
            self.show(self._frame)
        elif not visible:
            nodes: list[Batch] = [*self.points.values(), *self.arrows.values()]
            for node in nodes:
                node.hide()

    def show(self, frame: int) -> None:
        """Draw the contacts of a frame."""
        self._frame = frame
        if not self._visible:
            return
        contacts = self.frames.at(frame)
        for kind, points in self.points.items():
            mine = contacts.of(kind)
            points.show(mine.position)
            self.arrows[kind].show(mine.arrows())
