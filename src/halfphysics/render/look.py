"""The look of all pictures, films and pages: colours, materials and lights, named once.

Colours are sRGB, 0 to 1. Things have the same colours on a light and on a dark background; only
the `Theme` differs. This package's renderer and the browser draw with the same lights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Color = tuple[float, float, float]
Direction = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Theme:
    """The surroundings: a sky, and a ground that fades into it.

    Attributes:
        top, horizon: The sky at the upper edge of a picture, and where the ground ends.
        ground, line: The ground, and its lines.
        edge: Brightness of edges, as a multiple of that of their thing.
        ink, plate: Text, and what it is written on.
    """

    top: Color
    horizon: Color
    ground: Color
    line: Color
    edge: float
    ink: Color
    plate: Color


LIGHT = Theme(
    top=(0.78, 0.835, 0.89),
    horizon=(0.945, 0.955, 0.965),
    ground=(0.835, 0.85, 0.868),
    line=(0.715, 0.738, 0.762),
    edge=0.55,
    ink=(0.13, 0.15, 0.18),
    plate=(1.0, 1.0, 1.0),
)
DARK = Theme(
    top=(0.055, 0.065, 0.085),
    horizon=(0.165, 0.18, 0.205),
    ground=(0.205, 0.222, 0.245),
    line=(0.33, 0.35, 0.38),
    edge=1.35,
    ink=(0.90, 0.92, 0.94),
    plate=(0.10, 0.11, 0.13),
)

# -- people ---------------------------------------------------------------------------------------

#: Shirts, which tell people apart: neither the ghost's blue nor the yellow to red of forces.
PEOPLE: tuple[Color, ...] = (
    (0.12, 0.46, 0.43),
    (0.50, 0.32, 0.56),
    (0.46, 0.50, 0.24),
    (0.36, 0.40, 0.46),
)
#: Whole bodies in files of other programs, which have one colour a person.
BODIES: tuple[Color, ...] = (
    (0.84, 0.74, 0.66),
    (0.66, 0.72, 0.64),
    (0.76, 0.67, 0.76),
    (0.62, 0.70, 0.76),
)
SKIN: Color = (0.78, 0.57, 0.45)
HAIR: Color = (0.23, 0.17, 0.14)
TROUSERS: Color = (0.30, 0.32, 0.39)
SHOES: Color = (0.86, 0.85, 0.82)

#: The reference motion: a blue ghost of this opacity where it is away from the body.
GHOST: Color = (0.25, 0.51, 0.94)
GHOST_ALPHA = 0.30
#: Distances from the body over which the ghost appears [m]: below the first it is not drawn.
GHOST_FADE = (0.01, 0.03)

# -- scene ----------------------------------------------------------------------------------------

#: Free objects: strong colours.
OBJECTS: tuple[Color, ...] = (
    (0.94, 0.55, 0.22),
    (0.93, 0.74, 0.24),
    (0.83, 0.33, 0.36),
    (0.13, 0.60, 0.57),
    (0.52, 0.42, 0.74),
)
#: Furniture: wood and cloth, darker than the ground.
FURNITURE: tuple[Color, ...] = (
    (0.66, 0.53, 0.40),
    (0.47, 0.55, 0.55),
    (0.55, 0.52, 0.60),
    (0.60, 0.49, 0.46),
)
#: Walls, doors and other parts of a building.
WALL: Color = (0.88, 0.87, 0.84)
#: Opacity of a static that hides people: glass.
GLASS_ALPHA = 0.16

#: Distance of the lines on the ground [m], and their width in a picture [pixels].
GRID, GRID_WIDTH = 0.5, 0.9
#: Width of the edges of statics [pixels].
EDGE_WIDTH = 1.3

# -- light ----------------------------------------------------------------------------------------

#: Towards the lights, for a camera that looks along +y: a key light from the left with soft
#: shadows, and a weak fill light from the right.
KEY: Direction = (-0.55, -0.60, 1.45)
FILL: Direction = (0.85, -0.45, 0.30)


def turned(light: Direction, towards_camera: tuple[float, float]) -> Direction:
    """The direction to a light, for a camera in a horizontal direction (x, y) from the scene."""
    x, y = towards_camera
    length = math.hypot(x, y) or 1.0
    # From -y, where the camera is that looks along +y, to (x, y).
    c, s = -y / length, x / length
    return c * light[0] - s * light[1], s * light[0] + c * light[1], light[2]
