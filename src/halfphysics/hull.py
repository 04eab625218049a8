"""Convex hulls of point sets, however few or flat the points are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError

#: Least thickness [m] of a hull in any principal direction; thinner sets are thickened to it.
#: Collision and mesh compilers need volume, and no body part is thinner than a millimetre.
MIN_THICKNESS = 1e-3


@dataclass(frozen=True, kw_only=True, eq=False)
class Hull:
    """A convex polyhedron: vertices (n, 3) [m], outward triangles (m, 3), volume [m^3].

    Attributes:
        vertices: The corners only, in the order of the input points.
        faces: Indices into `vertices`, counter-clockwise seen from outside; a closed surface.
        volume: Enclosed volume [m^3].
        thickened: Whether the input was flat or had too few points and got `MIN_THICKNESS`.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    volume: float
    thickened: bool


def convex_hull(points: ArrayLike, min_thickness: float = MIN_THICKNESS) -> Hull:
    """Convex hull of points (n, 3) [m]; no points give an empty hull.

    Where the points span less than `min_thickness` [m] along a principal axis (a plane, a line,
    a single point), copies shifted along that axis make up the difference, half on either side.

    Raises:
        InputError: points of another shape than (n, 3), or not finite.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"convex hull: points have shape {points.shape}, expected (n, 3)")
    if not np.isfinite(points).all():
        raise InputError("convex hull: a point is not finite; check the mesh it comes from")
    if len(points) == 0:
        empty = np.zeros((0, 3), dtype=np.int32)
        return Hull(vertices=np.zeros((0, 3)), faces=empty, volume=0.0, thickened=False)
    solid, thickened = _thicken(points, min_thickness)
    vertices, faces = _closed_hull(solid)
    return Hull(
        vertices=vertices, faces=faces, volume=enclosed_volume(vertices, faces), thickened=thickened
    )


def enclosed_volume(vertices: ArrayLike, faces: ArrayLike) -> float:
    """Signed volume [m^3] that a closed surface encloses (divergence theorem), > 0 if outward."""
    vertices = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(faces)
    if len(faces) == 0:
        return 0.0
    # About the centre, so that a mesh far from the origin loses no digits.
    a, b, c = np.moveaxis((vertices - vertices.mean(axis=0))[faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _thicken(points: NDArray[np.float64], minimum: float) -> tuple[NDArray[np.float64], bool]:
    """Points with copies shifted along every principal axis that is thinner than `minimum`."""
    centred = points - points.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    extents = np.ptp(centred @ axes.T, axis=0)
    thin = extents < minimum
    for axis, extent in zip(axes[thin], extents[thin], strict=True):
        shift = 0.5 * (minimum - extent) * axis
        points = np.concatenate([points - shift, points + shift])
    return points, bool(thin.any())


def _closed_hull(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Corners and outward triangles; joggled where rounding leaves Qhull's facets not closed."""
    from scipy.spatial import ConvexHull

    for options in ("Qt", "QJ"):
        hull = ConvexHull(points, qhull_options=options)
        faces = hull.simplices.astype(np.int32)
        a, b, c = np.moveaxis(points[faces], 1, 0)
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
        faces[inward] = faces[inward][:, ::-1]
        if is_closed(faces):
            break
    corners, compact = np.unique(faces, return_inverse=True)
    return points[corners], compact.reshape(faces.shape).astype(np.int32)


def is_closed(faces: ArrayLike) -> bool:
    """Whether every directed edge of triangles (m, 3) occurs once, and once the other way."""
    faces = np.asarray(faces, dtype=np.int64)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    key = edges @ np.array([1 << 32, 1])
    back = edges @ np.array([1, 1 << 32])
    return len(np.unique(key)) == len(key) and bool(np.isin(back, key).all())
