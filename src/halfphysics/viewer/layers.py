"""The layers of a stage that show contacts, beside those of bodies and objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from halfphysics.render.rasterizer import Color
from halfphysics.viewer.coloring import BOUNDS, RAMP, Touched
from halfphysics.viewer.contacts import KINDS, SHORTEST, TENFOLD, ContactNodes, kinds
from halfphysics.viewer.figure import rgb
from halfphysics.viewer.stage import Layer, Stage

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Opacity of a translucent body.
GLASS = 0.55


class Glass:
    """Bodies and their patches drawn as glass, to show hidden contacts: a part of a `Layer`.

    Args:
        handles: viser's handles that have an opacity.
    """

    def __init__(self, handles: list[Any]) -> None:
        self._handles = handles
        self._visible = False

    @property
    def visible(self) -> bool:
        """Whether the bodies are drawn as glass."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        for handle in self._handles:
            handle.opacity = GLASS if visible else None


def add_layers(server: Any, stage: Stage) -> None:
    """Add contacts, touched parts and a translucent body to the `layers` of a stage.

    Args:
        server: The viser server.
        stage: A stage of a complete result.
    """
    if not len(stage.drawing.result.contacts.frame):
        return
    stage.layers["contacts"] = Layer("Contacts", [ContactNodes(server, stage)])
    touched = Touched(server, stage)
    stage.layers["touched"] = Layer("Touched parts", [touched])
    handles = [figure.handle for figure in stage.people]
    handles += [one.handle for patches in touched.patches for one in patches.values()]
    stage.layers["glass"] = Layer("Glass body", [Glass(handles)], _visible=False)


def legend(results: Sequence[Result]) -> str:
    """HTML legend of the arrows and colours of these results, for the panel."""
    there = sorted({int(kind) for result in results for kind in kinds(result)})
    rows = [
        f'<div><span style="{_DOT};background:{_css(KINDS[k].color)}"></span>'
        f"force {KINDS[k].label}</div>"
        for k in there
    ]
    bounds = [0.0, *BOUNDS]
    steps = "".join(
        f'<span style="flex:1;text-align:center"><span style="display:block;height:8px;'
        f'background:{_css(color)}"></span>{"" if k else "over "}{low:.0f}</span>'
        for k, (low, color) in enumerate(zip(bounds, RAMP, strict=True))
    )
    return (
        '<div style="font-size:12px;line-height:1.5;margin:8px 11px;color:#495057">'
        f"{''.join(rows)}"
        f"<div>Arrows: {100 * SHORTEST:.0f} cm at 1 N, {100 * TENFOLD:.0f} cm more at ten times"
        ' that</div><div style="margin-top:6px">Touched parts, by force [N]</div>'
        f'<div style="display:flex;gap:1px;line-height:1.3">{steps}</div></div>'
    )


_DOT = "display:inline-block;width:9px;height:9px;border-radius:5px;margin-right:7px"


def _css(color: Color) -> str:
    return "rgb({},{},{})".format(*rgb(color))
