"""Reuse of hidden figures: viser's page fails when a skinned mesh is removed."""

from __future__ import annotations

from typing import Any

import numpy as np

from halfphysics.body.body import Body
from halfphysics.render.rasterizer import Surface
from halfphysics.viewer.figure import Figure


class Wardrobe:
    """Creates figures, or reuses hidden ones: one for each body and role."""

    def __init__(self) -> None:
        self._figures: dict[Any, Figure] = {}

    def figure(
        self,
        server: Any,
        name: str,
        surface: Surface,
        body: Body,
        bones: Any = None,
        *,
        person: int = 0,
    ) -> Figure:
        """A `Figure` with these arguments; the first part of `name` is ignored."""
        role = name.split("/", 2)[2]
        key = (role, surface.color, np.asarray(body.rest_vertices).tobytes())
        if key not in self._figures:
            path = f"/people/{len(self._figures)}"
            self._figures[key] = Figure(server, path, surface, body, bones, person=person)
        figure = self._figures[key]
        figure.visible = True
        return figure

    def put_away(self) -> None:
        """Hide all figures."""
        for figure in self._figures.values():
            figure.visible = False
