"""A surface coloured by values at its vertices: cut into bands, each of one colour.

The renderer gives a surface one colour. Bands end on lines of equal value, so their borders are
smooth however coarse the mesh is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.cutting import cut
from halfphysics.render.look import Color
from halfphysics.render.pressure_colors import scale_end, shades
from halfphysics.render.rasterizer import Surface

if TYPE_CHECKING:
    from halfphysics.results.result import Result

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


@dataclass(frozen=True, kw_only=True, eq=False)
class SkinPressures:
    """Pressures on the skins of a result's people at the times of a film.

    Attributes:
        values: Of each person, of every vertex at every time (N, V) [Pa].
        end: Pressure at the end of the colours [Pa].
    """

    values: tuple[NDArray[np.float32], ...]
    end: float

    @staticmethod
    def of(result: Result, frames: Array) -> SkinPressures:
        """At fractional frames (N,), linear between those of the result.

        Raises:
            InputError: Nothing soft is pressed.
        """
        from halfphysics.results.skin_pressure import skin_pressure

        at = np.clip(frames, 0.0, len(result) - 1.0)
        low = np.floor(at).astype(np.int64)
        high, share = np.minimum(low + 1, len(result) - 1), (at - low).astype(np.float32)[:, None]
        given = [skin_pressure(result, k) for k in range(len(result.people))]
        values = tuple((1.0 - share) * one[low] + share * one[high] for one in given)
        largest = max(float(one.max(initial=0.0)) for one in values)
        return SkinPressures(values=values, end=1e3 * scale_end(1e-3 * largest))


def on_one_scale(pressures: Sequence[SkinPressures]) -> list[SkinPressures]:
    """The same pressures with one end of the colours, which holds all: pictures are compared."""
    end = max(one.end for one in pressures)
    return [replace(one, end=end) for one in pressures]


def _piece(surface: Surface, vertices: Array, faces: NDArray[np.int32], band: int) -> Surface:
    r, g, b = shades((band + 0.5) / BANDS).tolist() if band else surface.color
    color: Color = (r, g, b)
    return replace(surface, vertices=vertices, faces=faces, color=color)
