"""Pressure of a person's skin on a flat layer, by the triangles of the skin: no code of the core.

Each triangle is cut into four, and each part presses at its centre: depth below the surface times
the stiffness, over its area seen from above, where it faces down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SkinPressure:
    """Load [N], area that counts [m^2], largest pressure [Pa], centre of pressure (2,) [m]."""

    load: float
    area: float
    peak: float
    centre: np.ndarray


def pressed(vertices, faces, top, inside, stiffness, least=0.0) -> SkinPressure:
    """What the skin (V, 3) [m], with faces (F, 3), presses on a level layer.

    Args:
        vertices, faces: The skin in the world.
        top: Height of the unloaded surface [m].
        inside: Lowest and highest x and y of the layer (2, 2) [m].
        stiffness: [Pa/m].
        least: Pressure that counts for the area [Pa].
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    depth, area, place = [], [], []
    for p, q, r in corners:
        middle = (p + q + r) / 3.0
        depth.append(top - middle[:, 2])
        area.append(-0.5 * np.cross(q - p, r - p)[:, 2])  # seen from above; facing down counts
        place.append(middle[:, :2])
    depth, area, place = map(np.concatenate, (depth, area, place))
    on = (depth > 0.0) & (area > 0.0)
    on &= ((place > inside[0]) & (place < inside[1])).all(axis=1)
    pressure, area, place = stiffness * depth[on], area[on], place[on]
    force = pressure * area
    load = float(force.sum())
    return SkinPressure(
        load,
        float(area[pressure >= least].sum()),
        float(pressure.max(initial=0.0)),
        (force[:, None] * place).sum(axis=0) / max(load, 1e-12),
    )
