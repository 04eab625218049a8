"""Convex hull of a body part's skin, also for few or coplanar vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh_solids import convex_hull, solid_moments

Array = NDArray[np.float64]

#: Least thickness [m] of a hull along any principal axis of its points; thinner sets are
#: thickened to it. Collision and mesh compilers need volume, and no body part is thinner.
MIN_THICKNESS = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class PartHull:
    """A convex polyhedron.

    Attributes:
        vertices: Corners only (n, 3) [m], in the order of the input points.
        faces: Outward triangles (m, 3); a closed surface.
        volume: Enclosed volume [m^3].
        thickened: Whether the points were too flat or too few and got `MIN_THICKNESS`.
    """

    vertices: Array
    faces: NDArray[np.int32]
    volume: float
    thickened: bool


def part_hull(points: Array, what: str) -> PartHull:
    """Convex hull of finite points (n, 3) [m] of the part named `what`; of no points, empty.

    If the points span less than `MIN_THICKNESS` along a principal axis (a plane, a line, a single
    point), copies shifted along that axis add the missing thickness, half on either side.
    """
    if len(points) == 0:
        nothing = np.zeros((0, 3), dtype=np.int32)
        return PartHull(vertices=np.zeros((0, 3)), faces=nothing, volume=0.0, thickened=False)
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    extents = np.ptp(centred @ axes.T, axis=0)
    thin = extents < MIN_THICKNESS
    for axis, extent in zip(axes[thin], extents[thin], strict=True):
        shift = 0.5 * (MIN_THICKNESS - extent) * axis
        points = np.concatenate([points - shift, points + shift])
    vertices, faces = convex_hull(points, what)
    volume = solid_moments(vertices, faces)[0]
    return PartHull(vertices=vertices, faces=faces, volume=volume, thickened=bool(thin.any()))
