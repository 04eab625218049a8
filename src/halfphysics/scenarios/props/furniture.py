"""Furniture of boxes and of one mesh, for the scenarios with rooms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shapes import Box, Sphere
from halfphysics.scenarios.props import stage
from halfphysics.scene.scene import Scene

#: Friction of cloth against cloth: a seated person does not slide.
CLOTH = 0.6


def block(
    scene: Scene,
    name: str,
    low: ArrayLike,
    high: ArrayLike,
    friction: float = stage.WOOD,
    soft: str | None = None,
) -> None:
    """Add a static box between two corners (3,) [m], hard or of a soft material by its name."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    size = tuple(float(x) for x in high - low)
    scene.add_static(name, Box(size), position=0.5 * (low + high), friction=friction, soft=soft)


def table(
    scene: Scene, low: ArrayLike, high: ArrayLike, height: float, thick: float = 0.04
) -> None:
    """Add a "table" from `low` to `high` (2,) with its top at `height`, on four legs [m]."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    block(scene, "table", (*low, height - thick), (*high, height))
    leg, inset = 0.05, 0.04
    for i, x in (("near", low[0] + inset), ("far", high[0] - inset - leg)):
        for j, y in (("right", low[1] + inset), ("left", high[1] - inset - leg)):
            block(scene, f"table_leg_{i}_{j}", (x, y, 0.0), (x + leg, y + leg, height - thick))


def cushion(size: ArrayLike, rounding: float = 0.06) -> Mesh:
    """Closed mesh of a mattress of `size` (3,) [m] about the origin, with rounded edges."""
    half = 0.5 * np.asarray(size, dtype=np.float64)
    # The sum of a ball and a soft-cornered box that is smaller by the rounding.
    vertices, faces = Sphere(1.0).triangles()
    box = np.sign(vertices) * np.abs(vertices) ** 0.35
    box /= np.abs(box).max(axis=0)
    return Mesh((half - rounding) * box + rounding * vertices, faces)
