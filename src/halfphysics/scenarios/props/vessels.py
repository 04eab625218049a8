"""What the scenarios with a glass pour from: a tumbler, and a wine glass with its stem and foot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import shown
from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.shape_base import Shape
from halfphysics.geometry.shapes import Cylinder
from halfphysics.scenarios.props.lathe import turn

Array = NDArray[np.float64]

#: The tumbler [m].
RADIUS, HEIGHT = 0.035, 0.12
#: The wine glass: height, outer and inner radius [m]: foot, stem, bowl with a wall of 3 mm.
_WINE = np.array(
    [
        [0.000, 0.0340, 0.0000],
        [0.003, 0.0340, 0.0000],
        [0.010, 0.0060, 0.0000],
        [0.070, 0.0050, 0.0000],
        [0.082, 0.0220, 0.0000],
        [0.088, 0.0275, 0.0000],
        [0.088, 0.0275, 0.0240],
        [0.104, 0.0340, 0.0310],
        [0.130, 0.0350, 0.0320],
        [0.170, 0.0320, 0.0290],
    ]
)
#: Where it is held: the middle of the hand at this height; the bowl begins at that one [m].
_HELD, _BOWL = 0.126, 0.070


@dataclass(frozen=True, eq=False)
class Vessel:
    """Something round that a hand closes around; its origin is where the hand holds it.

    Attributes:
        shape: About its upright axis.
        pieces: Convex meshes that it touches by; None: as it is.
        below: How far its foot is below the origin [m].
        outline: Height and radius of what the hand meets (n, 2) [m]; its hull counts.
    """

    shape: Shape
    pieces: tuple[Mesh, ...] | None
    below: float
    outline: Array


def vessel(name: str) -> Vessel:
    """The one of this name.

    Raises:
        InputError: There is none.
    """
    if name not in VESSELS:
        raise InputError(f"shape: found {shown(name)}, expected {' or '.join(map(repr, VESSELS))}")
    return VESSELS[name]()


def _tumbler() -> Vessel:
    outline = np.array([[-0.5 * HEIGHT, RADIUS], [0.5 * HEIGHT, RADIUS]])
    return Vessel(Cylinder(RADIUS, HEIGHT), None, 0.5 * HEIGHT, outline)


def _wine() -> Vessel:
    profile = _WINE - [_HELD, 0.0, 0.0]
    turned = turn(profile)
    bowl = profile[_WINE[:, 0] >= _BOWL][:, :2]
    return Vessel(turned.mesh, turned.pieces, _HELD, bowl)


#: Name -> how it is made.
VESSELS: dict[str, Callable[[], Vessel]] = {"tumbler": _tumbler, "wine": _wine}
