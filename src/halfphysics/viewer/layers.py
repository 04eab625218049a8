"""What a stage shows of contacts: its layers beside bodies and things."""

from __future__ import annotations

from typing import Any

from halfphysics.viewer.coloring import Touched
from halfphysics.viewer.contacts import ContactNodes
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
