"""Solids from triangles: volume, centre, inertia of a closed mesh; the convex hull of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from halfphysics.errors import InputError

Array = NDArray[np.float64]


def solid_moments(vertices: Array, faces: NDArray[np.integer]) -> tuple[float, Array, Array]:
    """Signed volume [m^3], centre (3,) [m] and inertia (3, 3) about it at 1 kg/m^3 [kg m^2].

    Exact for a closed, consistently wound surface: the sum of signed tetrahedra. Inertia has
    the sign of the volume. A volume of zero gives the mean of the vertices and zeros.
    """
    origin = vertices[np.unique(faces)].mean(axis=0)  # near the solid: less cancellation
    a, b, c = np.moveaxis(vertices[faces] - origin, 1, 0)
    six = np.einsum("fi,fi->f", a, np.cross(b, c))
    volume = six.sum() / 6.0
    if volume == 0.0:
        return 0.0, origin, np.zeros((3, 3))
    total = a + b + c
    centre = np.einsum("f,fi->i", six, total) / 24.0 / volume
    second = sum(np.einsum("f,fi,fj->ij", six, x, x) for x in (total, a, b, c)) / 120.0
    second = second - volume * np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return float(volume), origin + centre, 0.5 * (inertia + inertia.T)


def convex_hull(points: Array, what: str) -> tuple[Array, NDArray[np.int32]]:
    """Convex hull of points (n, 3): its vertices (V, 3) and outward triangles (F, 3).

    Raises `InputError` (naming `what`) where the points lie in one plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        extent = np.ptp(points, axis=0) if len(points) else np.zeros(3)
        raise InputError(
            f"{what}: its {len(points)} vertices span no volume (extents "
            f"{', '.join(f'{e:g}' for e in extent)} m), expected a solid; "
            "give the mesh some thickness or use a Box"
        ) from error
    kept = np.sort(hull.vertices)
    place = np.full(len(points), -1)
    place[kept] = np.arange(len(kept))
    faces = hull.simplices.copy()
    a, b, c = np.moveaxis(points[faces], 1, 0)
    inward = np.einsum("fi,fi->f", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    faces = place[faces]
    order = np.lexsort(faces.T[::-1])
    return points[kept].copy(), faces[order].astype(np.int32)
