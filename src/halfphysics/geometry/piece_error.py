"""Error of convex pieces that replace a mesh: how far they stick out, what they leave uncovered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.machine import cores
from halfphysics.geometry.mesh import Mesh
from halfphysics.geometry.mesh_queries import MeshQuery

Array = NDArray[np.float64]

#: Samples of a surface, least of any one piece, and points through the volume.
SURFACE = 20_000
EACH = 100
LATTICE = 100_000
#: The root of x^4 = x + 1: in three dimensions the counterpart of the golden ratio.
_EVEN = 1.2207440846057596
#: A point this near to a face is on it: rounding of files and of Qhull [m].
_ON = 1e-7


@dataclass(frozen=True, kw_only=True)
class PieceError:
    """Error of convex pieces against the mesh that they replace.

    outside_mm: Farthest that the union of the pieces sticks out of the mesh [mm].
    inside_mm: Farthest that the mesh sticks out of the union [mm].
    volume_percent: Volume of the union over the mesh's, less 100 %; NaN where the mesh encloses
        nothing.
    """

    outside_mm: float
    inside_mm: float
    volume_percent: float


class Hull:
    """A convex piece, for queries of many points."""

    def __init__(self, piece: Mesh) -> None:
        from scipy.spatial import ConvexHull

        planes = np.unique(np.round(ConvexHull(piece.vertices).equations, 12), axis=0)
        self.normals, self.offsets = planes[:, :3], planes[:, 3]
        self.low, self.high = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
        self.corners, self._faces = piece.vertices, piece.faces

    @cached_property
    def query(self) -> MeshQuery:
        """Distances to its surface; built when first asked for."""
        return MeshQuery(self.corners, self._faces)

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) are inside or on it."""
        near = ((points >= self.low - _ON) & (points <= self.high + _ON)).all(axis=1)
        some = np.flatnonzero(near)
        near[some] = (points[some] @ self.normals.T + self.offsets).max(axis=1) <= _ON
        result: NDArray[np.bool_] = near
        return result


def piece_error(mesh: Mesh, pieces: Sequence[Mesh]) -> PieceError:
    """Distances and volumes of the union of convex `pieces` against `mesh`, by dense sampling.

    Inside the mesh is where its winding number is over 0.5: holes are bridged. Samples: the
    corners and points of both surfaces, and points spread through their common box.
    """
    hulls = [Hull(piece) for piece in pieces]
    low = np.minimum(mesh.vertices.min(axis=0), np.min([h.low for h in hulls], axis=0))
    high = np.maximum(mesh.vertices.max(axis=0), np.max([h.high for h in hulls], axis=0))
    lattice, cell = _lattice(low, high)
    total = sum(_areas(piece).sum() for piece in pieces)
    skin = np.concatenate(
        [_samples(p, max(EACH, int(SURFACE * _areas(p).sum() / total))) for p in pieces]
    )
    of_pieces = _covered(hulls, lattice)
    of_mesh = mesh.query.inside(lattice, threads=cores())
    out = np.concatenate(
        [skin[~mesh.query.inside(skin, threads=cores())], lattice[of_pieces & ~of_mesh]]
    )
    outside = mesh.query.closest(out, threads=cores())[0].max() if len(out) else 0.0
    surface = _samples(mesh, SURFACE)
    bare = np.concatenate([surface[~_covered(hulls, surface)], lattice[of_mesh & ~of_pieces]])
    inside = 0.0
    if len(bare):
        inside = distance_to_union(hulls, bare).max()
    volume = mesh.solid_volume
    # The difference of two counts of the same points has less variance than either count.
    more = (np.count_nonzero(of_pieces & ~of_mesh) - np.count_nonzero(of_mesh & ~of_pieces)) * cell
    return PieceError(
        outside_mm=_millimetres(float(outside)),
        inside_mm=_millimetres(float(inside)),
        volume_percent=float(100.0 * more / volume) if volume > 0.0 else float("nan"),
    )


def distance_to_union(hulls: Sequence[Hull], points: Array) -> Array:
    """Distance (n,) [m] of points (n, 3) outside of the union of hulls to its surface.

    A hull is asked about the points that are nearer to its box than to any corner of a hull.
    """
    from scipy.spatial import cKDTree

    corners = np.concatenate([hull.corners for hull in hulls])
    nearest: Array = cKDTree(corners).query(points)[0]
    for hull in hulls:
        beside = np.maximum(np.maximum(hull.low - points, points - hull.high), 0.0)
        some = np.flatnonzero(np.einsum("ni,ni->n", beside, beside) < nearest**2)
        if len(some):
            away = hull.query.closest(points[some], threads=cores())[0]
            nearest[some] = np.minimum(nearest[some], away)
    return nearest


def _millimetres(metres: float) -> float:
    return 0.0 if metres <= _ON else 1000.0 * metres


def _covered(hulls: Sequence[Hull], points: Array) -> NDArray[np.bool_]:
    """Whether points (n, 3) are in the union.

    Each hull is asked about the points between its ends along x, all of which are in one slice.
    """
    order = np.argsort(points[:, 0], kind="stable")
    along = points[order]
    found = np.zeros(len(points), dtype=bool)
    starts = np.searchsorted(along[:, 0], [hull.low[0] - _ON for hull in hulls], side="left")
    ends = np.searchsorted(along[:, 0], [hull.high[0] + _ON for hull in hulls], side="right")
    for hull, start, end in zip(hulls, starts, ends, strict=True):
        open_ = start + np.flatnonzero(~found[start:end])
        found[open_] = hull.holds(along[open_])
    result = np.empty_like(found)
    result[order] = found
    return result


def _lattice(low: Array, high: Array) -> tuple[Array, float]:
    """Points (n, 3) spread evenly in a box, and the volume per point [m^3].

    An additive recurrence spreads them evenly in all directions. A regular grid would align with
    walls that are thinner than its cells and count them twice or not at all.
    """
    size = np.maximum(high - low, 1e-9)
    share = (0.5 + np.outer(np.arange(1, LATTICE + 1), _EVEN ** -np.arange(1.0, 4.0))) % 1.0
    return low + share * size, float(size.prod() / LATTICE)


def _areas(mesh: Mesh) -> Array:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    result: Array = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return result


def _samples(mesh: Mesh, count: int) -> Array:
    """The corners of a mesh and `count` points spread over its area, always the same."""
    areas = _areas(mesh)
    if not areas.any():
        return mesh.vertices
    place = (np.arange(count) + 0.5) / count * areas.sum()
    face = np.minimum(np.searchsorted(np.cumsum(areas), place), len(areas) - 1)
    # Additive recurrence by the plastic number: even over the unit square, whatever the count.
    u = np.outer(np.arange(1, count + 1), [0.7548776662466927, 0.5698402909980532]) % 1.0
    u[u.sum(axis=1) > 1.0] = 1.0 - u[u.sum(axis=1) > 1.0]
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[face]], 1, 0)
    return np.concatenate([mesh.vertices, a + u[:, :1] * (b - a) + u[:, 1:] * (c - a)])
