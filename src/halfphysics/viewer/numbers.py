"""Numbers of a frame: clearance, contacts by name with their forces, deviation, support."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.support.support import UNSUPPORTED
from halfphysics.viewer.contacts import KINDS, NO_PERSON, ContactFrames

if TYPE_CHECKING:
    from halfphysics.results.result import Result

# Most contacts in the list; the rest is summed up in one row.
_MOST = 8
# Smaller upward forces are not in the list [N].
_LEAST = 1.0
_CELL = "padding:1px 0;vertical-align:top;line-height:1.3"


class Numbers:
    """The numbers of the frames of a result.

    Args:
        result: The result.
        label: Name of the result; empty: it is the only one.

    Attributes:
        with_support: Whether `html` says what holds people up.
    """

    def __init__(self, result: Result, label: str = "") -> None:
        self._result = result
        self._label = label
        self._frames = ContactFrames(result)
        self.with_support = False
        self._off = [1e3 * person.joint_errors()[1] for person in result.people]

    def contacts(self, frame: int) -> list[tuple[str, str, float, int]]:
        """The contacts of a frame, the largest force first.

        Returns:
            Part or object, the other part or item, force [N], index into `KINDS`.
        """
        here = self._frames.at(frame)
        size = np.linalg.norm(here.force, axis=1)
        rows = self._result.contacts
        out = []
        for k in np.argsort(-size, kind="stable").tolist():
            row = here.rows[k]
            if rows.person[row] < 0:
                subject = self._result.names[rows.subject[row]]
            else:
                subject = self._part(int(rows.person[row]), int(rows.part[row]))
            other = self._result.names[rows.other[row]]
            if rows.other_part[row] >= 0:
                first = len(self._result.names) - len(self._result.people)
                other = self._part(int(rows.other[row]) - first, int(rows.other_part[row]))
            out.append((subject, other, float(size[k]), int(here.kind[k])))
        return out

    def _part(self, person: int, part: int) -> str:
        name = JOINT_NAMES[part].replace("_", " ")
        if len(self._result.people) == 1:
            return name
        return f"{self._result.people[person].name}: {name}"

    def deviation(self, frame: int) -> list[tuple[str, float, str, float]]:
        """Deviation of people from their recorded motions.

        Returns:
            For each person: name, mean over the joints [mm], the joint with the largest
            deviation, that deviation [mm].
        """
        out = []
        for person, off in zip(self._result.people, self._off, strict=True):
            worst = int(np.argmax(off[frame]))
            name = JOINT_NAMES[worst].replace("_", " ")
            out.append((person.name, float(off[frame].mean()), name, float(off[frame, worst])))
        return out

    def support(self, frame: int) -> list[tuple[str, list[tuple[str, float]], float, bool]]:
        """What holds people up; works the support out if that was not done.

        Returns:
            For each person: name, the surfaces that push upwards with their upward force [N], the
            largest first, the upward force that is missing [N], whether the person is in flight.
        """
        out = []
        for person in self._result.people:
            support = person.support
            upward = support.force[frame] @ support.up
            order = np.argsort(-upward, kind="stable").tolist()
            forces = [(support.names[k], float(upward[k])) for k in order if upward[k] > _LEAST]
            missing = max(float(support.residual[frame, :3] @ support.up), 0.0)
            out.append((person.name, forces, missing, bool(support.airborne[frame])))
        return out

    def html(self, frame: int) -> str:
        """All numbers of a frame as HTML, for the panel."""
        clearance = 1e3 * float(self._result.clearance[frame])
        reach = 1e3 * float(self._result.settings.clearance_range)
        near = f"{clearance:.1f} mm" if np.isfinite(clearance) else f"over {reach:.0f} mm"
        lines = [_row("Clearance of people", near)]
        several = len(self._result.people) > 1
        for name, mean, joint, most in self.deviation(frame):
            subject = f"{html.escape(name)} " if several else ""
            lines.append(
                _row(f"{subject}{'off' if several else 'Off'} the ghost, mean", f"{mean:.0f} mm")
            )
            lines.append(_row(f"most: {joint}", f"{most:.0f} mm"))
        contacts = self.contacts(frame)
        total = sum(size for _, _, size, kind in contacts if kind != NO_PERSON)
        lines.append(_row(f"Contacts: {len(contacts)}, on people", f"{total:.0f} N"))
        for subject, other, size, kind in contacts[:_MOST]:
            red, green, blue = (round(255 * c) for c in KINDS[kind].color)
            dot = (
                f'<span style="display:inline-block;width:8px;height:8px;border-radius:4px;'
                f'background:rgb({red},{green},{blue});margin-right:6px"></span>'
            )
            label = f"{html.escape(subject)} on {html.escape(other)}"
            lines.append(_row(f"{dot}{label}", f"{size:.1f} N" if size < 100 else f"{size:.0f} N"))
        if len(contacts) > _MOST:
            rest = sum(size for _, _, size, _ in contacts[_MOST:])
            lines.append(_row(f"and {len(contacts) - _MOST} more", f"{rest:.0f} N"))
        lines += self._support_rows(frame) if self.with_support else []
        head = f"<b>{html.escape(self._label)}</b>, " if self._label else ""
        last = len(self._result.motion) - 1
        time = f"{head}frame {frame} of {last}, {frame / self._result.fps:.2f} s"
        return (
            f'<div style="font-size:13px;line-height:1.4;margin:8px 11px">{time}'
            f'<table style="width:100%;border-collapse:collapse;margin-top:4px">'
            f"{''.join(lines)}</table></div>"
        )

    def _support_rows(self, frame: int) -> list[str]:
        rows = []
        several = len(self._result.people) > 1
        for (name, forces, missing, flies), person in zip(
            self.support(frame), self._result.people, strict=True
        ):
            weight = max(person.support.weight, 1e-9)
            share = 100.0 * sum(force for _, force in forces) / weight
            subject = f"{html.escape(name)} held up" if several else "Held up"
            said = "in flight" if flies else f"{share:.0f} % of {weight:.0f} N"
            rows.append(_row(subject, said))
            rows += [_row(f"by {html.escape(item)}", f"{force:.0f} N") for item, force in forces]
            if missing > UNSUPPORTED * weight:
                rows.append(_row("by nothing, though needed", f"{missing:.0f} N"))
        return rows


class NumbersPanel:
    """The numbers of all results in the panel.

    Args:
        gui: viser's GUI, within the folder or tab of the numbers.
        results: The results.
        labels: Names of the results.
    """

    def __init__(self, gui: Any, results: Sequence[Result], labels: Sequence[str]) -> None:
        several = len(results) > 1
        self._numbers = [
            Numbers(result, label if several else "")
            for result, label in zip(results, labels, strict=True)
        ]
        self.texts = [gui.add_html("") for _ in results]
        self._shown = [-1] * len(results)

    def add_support(self) -> None:
        """Say what holds people up from now on."""
        for numbers in self._numbers:
            numbers.with_support = True
        self._shown = [-1] * len(self._shown)

    def show(self, frames: Sequence[int]) -> None:
        """Show the numbers of one frame of each result."""
        for k, frame in enumerate(frames):
            if frame != self._shown[k]:
                self._shown[k] = frame
                self.texts[k].content = self._numbers[k].html(frame)


def _row(left: str, right: str) -> str:
    return (
        f'<tr><td style="{_CELL}">{left}</td><td style="{_CELL};text-align:right;'
        f'padding-left:8px;white-space:nowrap">{html.escape(right)}</td></tr>'
    )
