"""The vessels of the scenarios with a glass: a tumbler, and a wine glass with stem and foot."""

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

#: Size of the tumbler [m].
RADIUS, HEIGHT = 0.035, 0.12
#: Profile of the wine glass: height, outer and inner radius [m]; the bowl's wall is 3 mm.
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
#: Heights of the middle of the holding hand and of the start of the bowl [m].
_HELD, _BOWL = 0.126, 0.070


@dataclass(frozen=True, eq=False)
class Vessel:
    """A round vessel that a hand closes around; its origin is the middle of the hand.

    Attributes:
        shape: The shape about its upright axis.
        pieces: Convex meshes for collision; None: from the shape.
        below: Distance of its foot below the origin [m].
        outline: Height and radius of the held part (n, 2) [m]; its hull is used.
    """

    shape: Shape
    pieces: tuple[Mesh, ...] | None
    below: float
    outline: Array


def vessel(name: str) -> Vessel:
    """The vessel of this name.

    Raises:
        InputError: There is no such vessel.
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


#: Name -> function that makes the vessel.
VESSELS: dict[str, Callable[[], Vessel]] = {"tumbler": _tumbler, "wine": _wine}
