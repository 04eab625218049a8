"""The marks of a time line: when there are contacts, holds, slips and drops.

- A contact of a kind (`contacts.KINDS`): frames in which a contact of that kind exerts a force of
  at least `LEAST`; pauses of up to `PAUSE` are part of it.
- Holds, slips and drops: as `labels.events` defines them. A drop goes from the release to the
  landing.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import HalfPhysicsError
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.render.rasterizer import Color
from halfphysics.viewer.contacts import KINDS, kinds
from halfphysics.viewer.figure import rgb

if TYPE_CHECKING:
    from halfphysics.labels.event_kinds import Drop, Events, Hold, Slip
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

#: Weaker contacts have no mark [N].
LEAST = 1.0
#: A pause between two contacts that is no pause of the mark [s].
PAUSE = 0.1
#: Colours of the rows of events.
HOLD: Color = (0.13, 0.60, 0.57)
SLIP: Color = (0.95, 0.62, 0.10)
DROP: Color = (0.86, 0.15, 0.18)
# Pairs that the text of a mark names.
_NAMED = 3


@dataclass(frozen=True)
class Mark:
    """From `start` to `end` [s], what there was in words."""

    start: float
    end: float
    text: str


@dataclass(frozen=True)
class Row:
    """The marks of one kind, in order."""

    label: str
    color: Color
    marks: tuple[Mark, ...]

    def document(self) -> dict[str, Any]:
        """The row as the browser reads it."""
        return {
            "label": self.label,
            "color": "rgb({},{},{})".format(*rgb(self.color)),
            "marks": [[round(m.start, 4), round(m.end, 4), m.text] for m in self.marks],
        }


def rows(results: Sequence[Result], labels: Sequence[str]) -> list[Row]:
    """The rows of one or several results, empty ones left out.

    Args:
        results: The results.
        labels: Their names, which the rows of several results begin with.
    """
    found = []
    for result, label in zip(results, labels, strict=True):
        prefix = f"{label}, " if len(results) > 1 else ""
        for row in [*contact_rows(result), *event_rows(result)]:
            found.append(Row(prefix + row.label, row.color, row.marks))
    return found


def contact_rows(result: Result) -> list[Row]:
    """A row for each kind of contact that occurs."""
    contacts = result.contacts
    force = np.linalg.norm(np.asarray(contacts.impulse), axis=1) * result.fps
    strong, kind = force >= LEAST, kinds(result)
    found = []
    for number in np.unique(kind[strong]).tolist():
        chosen = np.flatnonzero(strong & (kind == number))
        frame = np.asarray(contacts.frame)[chosen]
        # Of one interval: the rows between two pauses.
        cuts = np.flatnonzero(np.diff(frame) > PAUSE * result.fps + 1.0) + 1
        marks = tuple(_contact_mark(result, part, force[part]) for part in np.split(chosen, cuts))
        found.append(Row(kind_label(number), KINDS[number].color, marks))
    return found


def event_rows(result: Result) -> list[Row]:
    """Rows for the holds, slips and drops of a result; none where a scene or body is missing."""
    events = _events(result)
    if events is None:
        return []
    fps = result.fps
    kinds_of_events: list[tuple[str, Color, Iterable[Mark]]] = [
        ("hold", HOLD, map(_hold, events.holds)),
        ("slip", SLIP, map(_slip, events.slips)),
        ("drop", DROP, (_drop(drop, (len(result.motion) - 1) / fps) for drop in events.drops)),
    ]
    found = [Row(label, color, tuple(marks)) for label, color, marks in kinds_of_events]
    return [row for row in found if row.marks]


def _events(result: Result) -> Events | None:
    from halfphysics.labels.events import events
    from halfphysics.results.result import Result

    if not isinstance(result, Result) or not result.objects:
        return None
    try:
        return events(result)
    except HalfPhysicsError:  # a mesh or a body model is missing: the rest is shown
        return None


def kind_label(kind: int) -> str:
    """The label of the row of a kind of contact."""
    return (
        KINDS[kind]
        .label.replace("on a person, by", "contact with")
        .replace("on an object", "contact of objects")
    )


def _contact_mark(result: Result, rows_: NDArray[np.intp], force: Array) -> Mark:
    """The mark of contacts, which names the strongest pairs."""
    contacts, names = result.contacts, result.names
    strongest: dict[str, float] = {}
    for row, size in zip(rows_.tolist(), force.tolist(), strict=True):
        part, subject = int(contacts.part[row]), int(contacts.subject[row])
        what = JOINT_NAMES[part] if part >= 0 else names[subject]
        pair = f"{what.replace('_', ' ')} – {names[int(contacts.other[row])]}"
        strongest[pair] = max(strongest.get(pair, 0.0), size)
    ordered = sorted(strongest.items(), key=lambda entry: -entry[1])
    text = ", ".join(f"{pair} {size:.0f} N" for pair, size in ordered[:_NAMED])
    more = len(ordered) - _NAMED
    frames = np.asarray(contacts.frame)[rows_]
    # A contact of frame t happens during (t - 1, t].
    start = max(int(frames[0]) - 1, 0) / result.fps
    return Mark(start, int(frames[-1]) / result.fps, text + (f", {more} more" if more > 0 else ""))


def _hold(hold: Hold) -> Mark:
    how = "kept to the end" if hold.ending == "kept" else hold.ending
    return Mark(hold.start, hold.end, f"{hold.object} in {_parts(hold.parts)}, {how}")


def _slip(slip: Slip) -> Mark:
    text = f"{slip.object} slips {100.0 * slip.distance:.0f} cm in {_parts(slip.parts)}"
    return Mark(slip.start, slip.end, text)


def _drop(drop: Drop, end: float) -> Mark:
    onto = "" if drop.onto is None else f" onto {drop.onto}"
    text = f"{drop.object} falls {drop.height:.2f} m{onto}, {drop.speed:.1f} m/s"
    return Mark(drop.time, end if drop.landing is None else drop.landing, text)


def _parts(parts: Sequence[str]) -> str:
    shown = [part.replace("_", " ") for part in parts[:2]]
    return " and ".join(shown) + (f" and {len(parts) - 2} more" if len(parts) > 2 else "")
