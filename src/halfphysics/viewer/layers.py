"""The layers of a stage that show contacts and support, beside those of bodies and objects."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from halfphysics.render.rasterizer import Color
from halfphysics.viewer import support_overlay as overlay
from halfphysics.viewer.coloring import BOUNDS, RAMP, Touched
from halfphysics.viewer.contacts import KINDS, SHORTEST, TENFOLD, ContactNodes, kinds
from halfphysics.viewer.figure import rgb
from halfphysics.viewer.stage import Layer, Stage

if TYPE_CHECKING:
    from halfphysics.results.result import Result

#: Opacity of a translucent body.
GLASS = 0.55
#: Name of the layer of the support. The first time that it is shown may take a moment.
SUPPORT = "support"


class Glass:
    """Bodies and their patches, drawn as glass while any of the switches is on.

    Args:
        handles: viser's handles that have an opacity.
    """

    def __init__(self, handles: list[Any]) -> None:
        self._handles = handles
        self._switches: list[GlassSwitch] = []

    def switch(self) -> GlassSwitch:
        """A new switch, off."""
        self._switches.append(GlassSwitch(self))
        return self._switches[-1]

    def update(self) -> None:
        """Draw the bodies as the switches have them."""
        opacity = GLASS if any(switch.visible for switch in self._switches) else None
        for handle in self._handles:
            if handle.opacity != opacity:
                handle.opacity = opacity


class GlassSwitch:
    """One of several reasons to draw the bodies as glass: a part of a `Layer`."""

    def __init__(self, glass: Glass) -> None:
        self._glass = glass
        self._visible = False

    @property
    def visible(self) -> bool:
        """Whether it is on."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = visible
        self._glass.update()


def add_layers(server: Any, stage: Stage) -> None:
    """Add contacts, touched parts, support and a translucent body to the `layers` of a stage.

    Args:
        server: The viser server.
        stage: A stage of a complete result.
    """
    handles = [handle for figure in stage.people for handle in figure.handles.values()]
    if len(stage.drawing.result.contacts.frame):
        stage.layers["contacts"] = Layer("Contacts", [ContactNodes(server, stage)])
        touched = Touched(server, stage)
        stage.layers["touched"] = Layer("Touched parts", [touched], _visible=False)
        touched.visible = False
        handles += [one.handle for patches in touched.patches for one in patches.values()]
    if not handles:
        return
    glass = Glass(handles)
    # Soles hide what presses on them, and legs the arrows: the body is glass with the support.
    parts = [overlay.SupportOverlay(server, stage), glass.switch()]
    stage.layers[SUPPORT] = Layer("Support", parts, _visible=False)
    stage.layers["glass"] = Layer("Glass body", [glass.switch()], _visible=False)


def show_support(server: Any, stage: Stage) -> None:
    """Show the support of a stage for good, with the bodies as glass."""
    overlay.SupportOverlay(server, stage).visible = True
    for figure in stage.people:
        for handle in figure.handles.values():
            handle.opacity = GLASS


def legend(results: Sequence[Result]) -> str:
    """HTML legend of the arrows and colours of the contacts of these results, for the panel."""
    there = sorted({int(kind) for result in results for kind in kinds(result)})
    rows = [_entry(KINDS[kind].color, f"force {KINDS[kind].label}") for kind in there]
    lengths = f"{100 * SHORTEST:.0f} cm at 1 N, {100 * TENFOLD:.0f} cm more at ten times that"
    return _legend([*rows, f"<div>Arrows: {lengths}</div>"], "Touched parts, by force [N]", BOUNDS)


def support_legend() -> str:
    """HTML legend of the arrows and colours of the support, for the panel."""
    rows = [
        *(_entry(color, label) for color, label in overlay.KEY),
        f"<div>Arrows: 1 m for {1 / overlay.SCALE:.0f} N</div>",
    ]
    kilopascals = [1e-3 * bound for bound in overlay.BOUNDS]
    return _legend(rows, "Pressure on the skin [kPa]", kilopascals)


def hint(text: str) -> str:
    """HTML of a line of text, for the panel."""
    return f'<div style="{_TEXT}">{html.escape(text)}</div>'


def _legend(rows: Sequence[str], title: str, bounds: Sequence[float]) -> str:
    """HTML of rows, and below a title the colours of `RAMP` between bounds."""
    steps = "".join(
        f'<span style="flex:1;text-align:center"><span style="display:block;height:8px;'
        f'background:{_css(color)}"></span>{"" if k else "over "}{low:.0f}</span>'
        for k, (low, color) in enumerate(zip([0.0, *bounds], RAMP, strict=True))
    )
    return (
        f'<div style="{_TEXT}">{"".join(rows)}<div style="margin-top:6px">{title}</div>'
        f'<div style="display:flex;gap:1px;line-height:1.3">{steps}</div></div>'
    )


def _entry(color: Color, label: str) -> str:
    return f'<div><span style="{_DOT};background:{_css(color)}"></span>{label}</div>'


_TEXT = "font-size:12px;line-height:1.5;margin:8px 11px;color:#495057"
_DOT = "display:inline-block;width:9px;height:9px;border-radius:5px;margin-right:7px"


def _css(color: Color) -> str:
    return "rgb({},{},{})".format(*rgb(color))
