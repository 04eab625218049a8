"""What a stage shows of contacts: its layers beside bodies and things."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.render import Color
from halfphysics.viewer.coloring import BOUNDS, RAMP, Touched
from halfphysics.viewer.contacts import KINDS, ContactNodes, arrow_lengths
from halfphysics.viewer.figure import rgb
from halfphysics.viewer.stage import Layer, Stage

#: How much is left of a body that is seen through.
GLASS = 0.55


class Glass:
    """Bodies and what is on them as glass, to see contacts that they hide: a part of a `Layer`.

    Args:
        handles: Of viser, with an opacity.
    """

    def __init__(self, handles: list[Any]) -> None:
        self._handles = handles
        self._visible = False

    @property
    def visible(self) -> bool:
        """Whether it is glass."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        for handle in self._handles:
            handle.opacity = GLASS if visible else None


def add_layers(server: Any, stage: Stage) -> None:
    """Contacts, parts that touch and a body to see through, as `layers` of a stage.

    Args:
        server: Of viser.
        stage: With a whole result.
    """
    if not len(stage.drawing.result.contacts.frame):
        return
    stage.layers["contacts"] = Layer("Contacts", [ContactNodes(server, stage)])
    touched = Touched(server, stage)
    stage.layers["touched"] = Layer("Touched parts", [touched])
    handles = [figure.handle for figure in stage.people]
    handles += [one.handle for patches in touched.patches for one in patches.values()]
    stage.layers["glass"] = Layer("Glass body", [Glass(handles)], _visible=False)


def legend() -> str:
    """What arrows and colours mean, for the panel."""
    rows = [
        _entry(f'<span style="{_DOT};background:{_css(kind.color)}"></span>', f"force {kind.label}")
        for kind in KINDS
    ]
    sizes = ", ".join(
        f"{100 * float(arrow_lengths(np.array(newton))):.0f} cm" for newton in (1, 10, 100, 1000)
    )
    bounds = [0.0, *BOUNDS]
    steps = "".join(
        f'<span style="flex:1;text-align:center"><span style="display:block;height:8px;'
        f'background:{_css(color)}"></span>{"" if k else "over "}{low:.0f}</span>'
        for k, (low, color) in enumerate(zip(bounds, RAMP, strict=True))
    )
    return (
        '<div style="font-size:12px;line-height:1.5;margin:8px 11px;color:#495057">'
        f"{''.join(rows)}"
        f"<div>Arrows of 1, 10, 100, 1000 N: {sizes}</div>"
        "<div>Touched parts by their force [N]:</div>"
        f'<div style="display:flex;gap:1px;line-height:1.3">{steps}</div></div>'
    )


_DOT = "display:inline-block;width:9px;height:9px;border-radius:5px;margin-right:7px"


def _entry(mark: str, text: str) -> str:
    return f"<div>{mark}{text}</div>"


def _css(color: Color) -> str:
    return "rgb({},{},{})".format(*rgb(color))
