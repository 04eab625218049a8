"""Whether a mesh of static geometry is in metres and the right way up, by its extent and floor.

Files of meshes say neither. Rooms are a few metres high, so that one whose smallest extent is over
a hundred is in centimetres or millimetres. Which axis is up is seen in two ways. Models are built
on zero and about zero: the axis along which one begins at zero, while it lies to both sides of zero
along the others, is up. And rooms have a floor, a level surface as wide as they are, at their
lowest: the axis that has one is up where the other has no wall there. A closed room away from zero
says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: Smallest extent from which on a mesh is in another unit -> metres per unit, its name [m as read].
_UNITS = ((1000.0, 0.001, "millimetres"), (100.0, 0.01, "centimetres"))
#: Extents of a room: height, and width [m]; smaller things say nothing by their surfaces.
_HIGH, _WIDE = 1.5, 2.5
#: A model begins at zero to within this share of its extent, and reaches beyond this share of its
#: extent to both sides of zero along the other axes.
_AT_ZERO, _ABOUT_ZERO = 0.01, 0.3
#: Smallest thing that says which way is up by where it begins [m].
_LEAST = 0.3
#: A floor is so thick, as a share of the height, and level to within the angle of this cosine.
_THICK, _LEVEL = 0.05, 0.9
#: Shares of the footprint that a floor has at least, and that the axis read as up has at most.
_FLOOR, _NO_FLOOR = 0.6, 0.2
#: Triangles that are looked at: of larger meshes, evenly many fewer.
_MOST = 200_000


@dataclass(frozen=True)
class Doubts:
    """What the mesh looks like instead.

    Attributes:
        extent: Of the mesh as read (3,) [m].
        unit: Metres per unit, and the unit's name; None: metres.
        up: The axis that seems to be up in the file; None: the one it was read with.
    """

    extent: Array
    unit: tuple[float, str] | None = None
    up: str | None = None


def doubts(mesh: Mesh, read_up: str) -> Doubts:
    """What of a mesh seems to be read wrongly.

    Args:
        mesh: As it was read: in metres, z up.
        read_up: The axis of its file that was taken as up, "y" or "z".
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    extent = high - low
    unit = next(((per, name) for least, per, name in _UNITS if extent.min() >= least), None)
    # The other axis of the file is y of the world, or against it, since y up was turned to z up.
    other = 1.0 if read_up == "z" else -1.0
    metres = unit[0] if unit else 1.0
    stands = _begins_at_zero(low, high, other, metres) or _has_floor(mesh, extent, other, metres)
    up = {"z": "y", "y": "z"}[read_up] if stands else None
    return Doubts(extent, unit, up)


def _begins_at_zero(low: Array, high: Array, other: float, metres: float) -> bool:
    """Whether the other axis begins at zero, and the axis read as up lies about zero as x does."""
    extent = high - low
    if extent.min() * metres < _LEAST:
        return False
    begins = low[1] if other > 0.0 else -high[1]
    beyond = np.minimum(-low, high) / extent
    return bool(abs(begins) <= _AT_ZERO * extent[1] and (beyond[[0, 2]] >= _ABOUT_ZERO).all())


def _has_floor(mesh: Mesh, extent: Array, other: float, metres: float) -> bool:
    """Whether there is a floor along the other axis, and none along the one read as up."""
    size = extent * metres
    if size.min() < _HIGH or min(size[0], size[2]) < _WIDE:
        return False
    corners = mesh.vertices[mesh.faces[:: max(1, len(mesh.faces) // _MOST)]]
    share = len(mesh.faces) / len(corners)
    normals = 0.5 * share * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middles = corners.mean(axis=1)
    floor = _lowest(middles[:, 1] * other, normals[:, 1], normals) / (extent[0] * extent[2])
    read = _lowest(middles[:, 2], normals[:, 2], normals) / (extent[0] * extent[1])
    return bool(floor >= _FLOOR and read <= _NO_FLOOR)


def _lowest(heights: Array, along: Array, normals: Array) -> float:
    """Area of the level triangles that are lowest; normals are as long as the areas."""
    areas = np.linalg.norm(normals, axis=1)
    thick = _THICK * np.ptp(heights)
    level = (np.abs(along) >= _LEVEL * areas) & (heights <= heights.min() + thick)
    return float(areas[level].sum())
