"""Solids of revolution: a profile about an upright axis, as a mesh and as convex pieces.

A solid has `sides` flat sides, so that its pieces fill the mesh exactly: between two heights of
the profile a solid part is one piece, a wall is one wedge per side.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError
from halfphysics.geometry.mesh import Mesh

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Turned:
    """A turned solid: its closed surface, and convex pieces that fill its volume exactly."""

    mesh: Mesh
    pieces: tuple[Mesh, ...]


def turn(profile: ArrayLike, sides: int = 16) -> Turned:
    """A solid of revolution with flat sides about z, its corners on the profile.

    Args:
        profile: Rows of height, outer and inner radius (n, 3) [m], heights rising. An inner
            radius of 0 is solid. Between two rows both surfaces are straight; a wall on a solid
            part has a floor at that height: give the height twice.
        sides: Number of flat sides, at least 3.

    Raises:
        InputError: The rows are not the profile of one solid.
    """
    rows = np.asarray(profile, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1:] != (3,) or len(rows) < 2 or not np.isfinite(rows).all():
        raise InputError(
            f"profile: found shape {rows.shape}, expected rows of height, outer and inner radius"
        )
    height, outer, inner = rows.T
    if (np.diff(height) < 0.0).any() or (inner < 0.0).any() or (outer <= inner).any():
        raise InputError(
            "profile: expected heights that rise, and outer radii larger than inner ones"
        )
    if sides < 3:
        raise InputError(f"sides: found {sides}, expected 3 or more")
    pieces: list[Mesh] = []
    for low, high in itertools.pairwise(rows):
        if low[0] == high[0]:
            continue
        if (low[2] > 0.0) != (high[2] > 0.0):
            raise InputError(
                f"profile: inner radius {low[2]:g} to {high[2]:g} m between heights {low[0]:g} and "
                f"{high[0]:g}, expected both 0 or both above: give the height of the floor twice"
            )
        if low[2] == 0.0:
            ring = np.vstack([_ring(row[1], row[0], sides) for row in (low, high)])
            pieces.append(Mesh(ring, _hull_faces(ring)))
            continue
        corners = np.stack([_ring(row[c], row[0], sides) for row in (low, high) for c in (1, 2)])
        for k in range(sides):
            wedge = corners[:, [k, (k + 1) % sides]].reshape(-1, 3)
            pieces.append(Mesh(wedge, _hull_faces(wedge)))
    return Turned(_surface(rows, sides), tuple(pieces))


def _ring(radius: float, height: float, sides: int) -> Array:
    angle = np.arange(sides) * 2.0 * np.pi / sides
    return np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.full(sides, height)], axis=1
    )


def _hull_faces(points: Array) -> NDArray[np.int32]:
    """Outward-oriented triangles of the hull of points that are all its corners."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    faces = np.asarray(hull.simplices, dtype=np.int32)
    first, second, third = (points[faces[:, i]] for i in range(3))
    normal = np.cross(second - first, third - first)
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return faces


def _surface(rows: Array, sides: int) -> Mesh:
    """The closed surface: up the outside, over the rim, down the inside, a fan at either axis."""
    up = [(radius, height) for height, radius, _ in rows]
    down = [(radius, height) for height, _, radius in rows[::-1] if radius > 0.0]
    way = [point for i, point in enumerate(up) if i == 0 or point != up[i - 1]] + down
    vertices = [np.array([0.0, 0.0, way[0][1]]), np.array([0.0, 0.0, way[-1][1]])]
    rings = np.vstack([_ring(radius, height, sides) for radius, height in way])
    first = 2 + sides * np.arange(len(way))
    k = np.arange(sides)
    after = (k + 1) % sides
    faces = [np.stack([0 * k, first[0] + after, first[0] + k], axis=1)]
    for a, b in itertools.pairwise(first):
        faces.append(np.stack([a + k, a + after, b + after], axis=1))
        faces.append(np.stack([a + k, b + after, b + k], axis=1))
    faces.append(np.stack([1 + 0 * k, first[-1] + k, first[-1] + after], axis=1))
    return Mesh(np.vstack([vertices, rings]), np.vstack(faces))
