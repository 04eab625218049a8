"""A surface coloured by values at its vertices: cut into bands, each of one colour.

The renderer gives a surface one colour. Bands end on lines of equal value, so their borders are
smooth however coarse the mesh is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.cutting import cut
from halfphysics.render.look import Color
from halfphysics.render.pressure_colors import shades
from halfphysics.render.rasterizer import Surface

Array = NDArray[np.float64]

#: Bands of a scale; the lowest is the surface's own colour.
BANDS = 12


def banded(surface: Surface, values: Array, end: float) -> list[Surface]:
    """The surface in pieces coloured by pressure.

    Args:
        surface: The surface; where there is no pressure it keeps its colour.
        values: Pressure at its vertices (V,).
        end: Pressure at the end of the colours; what is above has the last one.
    """
    values = np.asarray(values, dtype=np.float64)
    bounds = end * np.arange(1, BANDS) / BANDS
    vertices, faces = surface.vertices, surface.faces
    out: list[Surface] = []
    for band, bound in enumerate([*bounds.tolist(), np.inf]):
        above = values >= bound
        if not above.any():
            out.append(_piece(surface, vertices, faces, band))
            break
        low, high = cut(bound - values, faces), cut(values - bound, faces)
        if len(low.faces):
            out.append(_piece(surface, low.of(vertices), low.faces, band))
        if not len(high.faces):
            break
        vertices, values, faces = high.of(vertices), high.of(values), high.faces
    return out


def _piece(surface: Surface, vertices: Array, faces: NDArray[np.int32], band: int) -> Surface:
    r, g, b = shades((band + 0.5) / BANDS).tolist() if band else surface.color
    color: Color = (r, g, b)
    return replace(surface, vertices=vertices, faces=faces, color=color)
