"""The key of a page in HTML: the meaning of its colours, its notes, and what hands held."""

from __future__ import annotations

import html
from collections.abc import Sequence

from halfphysics.render.look import GHOST, PEOPLE
from halfphysics.render.rasterizer import Color
from halfphysics.render.result_meshes import Drawing
from halfphysics.results.hold_lines import hold_lines
from halfphysics.viewer.coloring import RAMP
from halfphysics.viewer.contacts import KINDS
from halfphysics.viewer.figure import rgb
from halfphysics.viewer.motions import is_untouched
from halfphysics.viewer.support_overlay import KEY


def key(
    drawings: Sequence[Drawing],
    contacts: Sequence[int],
    support: bool = False,
    notes: Sequence[str] = (),
) -> str:
    """The key of a page.

    Args:
        drawings: The drawings that the page shows.
        contacts: Kinds of contacts on the page, indices into `KINDS`.
        support: Whether the page shows the support of people.
        notes: Lines of text.
    """
    people = max(len(drawing.result.people) for drawing in drawings)
    bodies = [PEOPLE[k % len(PEOPLE)] for k in range(people)]
    entries = [([GHOST], "reference"), (bodies, "simulated")]
    if all(is_untouched(drawing.result) for drawing in drawings):
        entries = []
    for k, kind in enumerate(contacts):
        label = KINDS[kind].label.removeprefix("on a person, ")
        entries.append(([KINDS[kind].color], label if k else f"force {label}"))
    if support:
        entries += [([color], label) for color, label in KEY]
    said = "".join(
        f"<span>{''.join(map(_patch, colors))}{html.escape(label)}</span>"
        for colors, label in entries
    )
    lines = list(notes)
    for result in (drawing.result for drawing in drawings):
        if result.holds:
            lines += [line for k in range(len(result.people)) for line in hold_lines(result, k)]
    told = "".join(f"<div>{html.escape(line)}</div>" for line in lines)
    return f"{said}{scale() if contacts else ''}{told}"


def scale() -> str:
    """The colours of the skin by force, on their logarithmic scale."""
    colors = ", ".join(f"rgb{rgb(color)}" for color in RAMP)
    return (
        '<div style="margin-top:4px">force on the skin</div>'
        f'<div class="hp-scale" style="background:linear-gradient(90deg, {colors})"></div>'
        '<div class="hp-ends"><span>1 N</span><span>10</span><span>100</span>'
        "<span>1 kN</span></div>"
    )


def _patch(color: Color) -> str:
    return f'<i style="background: rgb{rgb(color)}"></i>'
