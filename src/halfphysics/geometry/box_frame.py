"""The frame in which most of a solid's surface is square to an axis.

coacd cuts along the axes only: an L of two boxes, turned by 30 degrees, became a staircase of 15
pieces in place of 2. What people build is mostly square to three axes of its own, so that these are
found and the solid is cut in them (`solid_cutting`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]

#: Normals within this angle of each other are of one direction: scans are uneven by degrees [rad].
_CONE = np.radians(3.0)
#: Directions that are tried: those with the largest area.
_TRIED = 32
#: Normals are grouped to this before they are tried.
_GRID = 1e-3
#: Triangles that are looked at, evenly taken from more.
_LOOKS = 50_000
#: Least share of the surface that is square to the three axes: of a ball or a person there is none.
_SHARE = 0.3
#: Axes are those of the world where they are as near: their pieces stay what they were.
_SAME = 1e-9


def box_frame(mesh: Mesh) -> Array | None:
    """The axes of a mesh that is mostly square to three of its own.

    Args:
        mesh: Closed or not.

    Returns:
        (3, 3) rotation with the axes as columns, so that `vertices @ frame` are in the frame; None:
        it has no such axes, or they are those in which it is given.
    """
    corners = mesh.vertices[mesh.faces[:: -(-len(mesh.faces) // _LOOKS)]]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(cross, axis=1)
    seen = areas > 0.0
    normals, areas = cross[seen] / areas[seen, None], areas[seen]
    first = _heaviest(normals, areas)
    if first is None:
        return None
    across = np.abs(normals @ first) < np.sin(_CONE)
    second = _heaviest(normals[across], areas[across])
    if second is None:
        return None
    second = second - (second @ first) * first
    second /= np.linalg.norm(second)
    frame = np.column_stack([first, second, np.cross(first, second)])
    square = (np.abs(normals @ frame) > np.cos(_CONE)).any(axis=1)
    if areas[square].sum() < _SHARE * areas.sum():
        return None
    if np.all(np.abs(frame).max(axis=0) > 1.0 - _SAME):
        return None
    return frame


def _directions(normals: Array, areas: Array) -> Array:
    """(n, 3) the directions with the largest area, the largest first, without their sign."""
    # Opposite normals are one direction: the first component that is not zero is positive.
    flat = np.round(normals / _GRID)
    lead = flat[np.arange(len(flat)), (flat != 0).argmax(axis=1)]
    keys, group = np.unique(flat * np.sign(lead)[:, None], axis=0, return_inverse=True)
    weight = np.bincount(group.ravel(), areas, len(keys))
    tried = keys[np.argsort(-weight, kind="stable")[:_TRIED]]
    result: Array = tried / np.linalg.norm(tried, axis=1, keepdims=True)
    return result


def _heaviest(normals: Array, areas: Array) -> Array | None:
    """The direction with the most area around it, in the middle of that area."""
    if not len(normals):
        return None
    tried = _directions(normals, areas)
    along = normals @ tried.T
    near = np.abs(along) > np.cos(_CONE)
    best = int((near * areas[:, None]).sum(axis=0).argmax())
    signs = np.sign(along[near[:, best], best])
    middle = (normals[near[:, best]] * (signs * areas[near[:, best]])[:, None]).sum(axis=0)
    result: Array = middle / np.linalg.norm(middle)
    return result
