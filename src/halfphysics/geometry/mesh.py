"""A triangle mesh as a shape: its solid, its convex hull, point queries against it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.base.arrays import array_of, as_array
from halfphysics.base.copying import ReadOnly
from halfphysics.base.short_repr import counted, numbers
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.geometry import mesh_queries, mesh_solids
from halfphysics.geometry.shape_base import Array, MassProperties, Shape, Triangles


@dataclass(frozen=True, kw_only=True)
class MeshSource:
    """The file of a mesh and its transform: enough to read it again.

    `path` absolute, `sha256` of that file's content, `scale` applied, `up` axis of the file.
    """

    path: str
    sha256: str
    scale: float = 1.0
    up: str = "z"


@dataclass(frozen=True, eq=False)
class Mesh(ReadOnly, Shape):
    """Triangles: `vertices` (V, 3) [m], `faces` (F, 3), counter-clockwise seen from outside.

    Vertices at exactly one place are merged, unused ones and triangles without three different
    corners dropped. The arrays are read-only. Raises `InputError`: no triangles, NaN, wrong
    shapes or indices.
    """

    vertices: Array
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        vertices, faces = self._given()
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise InputError(f"Mesh: vertices: expected shape (V, 3), found {vertices.shape}")
        if faces.size == 0:
            raise InputError("Mesh: found no triangles, expected faces (F, 3) with F > 0")
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
            raise InputError(
                f"Mesh: faces: expected whole numbers (F, 3), found {faces.dtype} {faces.shape}"
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise InputError(
                f"Mesh: faces: expected indices from 0 to {len(vertices) - 1}, found "
                f"{faces.min()} to {faces.max()}"
            )
        bad = ~np.isfinite(vertices).all(axis=1)
        if bad.any():
            raise InputError(
                f"Mesh: vertices: {bad.sum()} of {len(vertices)} are NaN or infinite, the first "
                f"is number {np.argmax(bad)}; expected finite coordinates [m]"
            )
        vertices, kept = mesh_queries.merge_vertices(vertices, faces)
        if not len(kept):
            raise InputError("Mesh: none of its triangles has three different corners")
        vertices.setflags(write=False)
        kept.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", kept)

    def _given(self) -> tuple[Array, NDArray[Any]]:
        """Vertices and faces as arrays, of any shape."""
        what = "vertices: expected numbers (V, 3)"
        try:
            vertices = np.asarray(array_of(self.vertices), dtype=np.float64)
            what = "faces: expected whole numbers (F, 3)"
            return vertices, as_array(self.faces)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(f"Mesh: {what}, found something else ({error})") from None

    def __repr__(self) -> str:
        return (
            f"Mesh({counted(len(self.vertices), 'vertex', 'vertices')}, "
            f"{counted(len(self.faces), 'triangle')}, "
            f"{numbers(np.ptp(self.vertices, axis=0))} m)"
        )

    @cached_property
    def closed(self) -> bool:
        """Whether every edge is used as often one way as the other: the mesh bounds a solid."""
        return mesh_queries.is_closed(self.faces, len(self.vertices))

    @property
    def outward(self) -> Mesh:
        """The mesh, turned right side out where it is closed and inside out, as mirrored exports
        are: the same solid."""
        return self._turned or self

    @cached_property
    def _turned(self) -> Mesh | None:
        if self.closed and mesh_solids.solid_moments(self.vertices, self.faces)[0] < 0.0:
            return Mesh(self.vertices, self.faces[:, ::-1])
        return None

    @cached_property
    def query(self) -> mesh_queries.MeshQuery:
        """Point queries against this mesh, right side out (`outward`); built once."""
        return mesh_queries.MeshQuery(self.vertices, self.outward.faces)

    @cached_property
    def hull(self) -> Mesh:
        """The convex hull. Raises `InputError` where all vertices lie in one plane."""
        return Mesh(*mesh_solids.convex_hull(self.vertices, "Mesh"))

    @cached_property
    def _moments(self) -> tuple[float, Array, Array]:
        """Volume, centre, inertia at 1 kg/m^3, of the solid or else of the hull."""
        if self.closed:
            volume, centre, inertia = mesh_solids.solid_moments(self.vertices, self.faces)
            if volume != 0.0:  # inside out: the same solid
                return abs(volume), centre, inertia * np.sign(volume)
        hull = self.hull
        return mesh_solids.solid_moments(hull.vertices, hull.faces)

    @property
    def volume(self) -> float:
        """Volume [m^3]; of the convex hull where the mesh is not closed."""
        return self._moments[0]

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) [m] for even density."""
        return self._moments[1]

    def unit_inertia(self) -> Array:
        """Inertia (3, 3) about the centre of mass at 1 kg [m^2]."""
        return self._moments[2] / self._moments[0]

    def mass_properties(
        self, *, mass: float | None = None, density: float | None = None
    ) -> MassProperties:
        """As for any shape; warns where the mesh is not closed and its hull is taken."""
        if not self.closed:
            warnings.warn(
                "Mesh: not closed, so it bounds no solid: volume, centre of mass and inertia are "
                "those of its convex hull. Close the mesh, or give mass= and com=.",
                HalfPhysicsWarning,
                stacklevel=2,
            )
        return super().mass_properties(mass=mass, density=density)

    def convex_vertices(self) -> Array:
        """Vertices of the convex hull (n, 3) [m]."""
        return self.hull.vertices

    @cached_property
    def solid_volume(self) -> float:
        """Volume of the points inside [m^3]: exact for one closed piece, else sampled to 1 %.

        Overlapping pieces count once and holes are bridged (winding number over 0.5).
        """
        if self.closed and mesh_queries.piece_count(self.faces, len(self.vertices)) == 1:
            return abs(self._moments[0])
        low, high = self.query.bounds
        # A lattice of 32^3 points, off the symmetric places where faces often lie.
        steps = [
            l + (np.arange(32) + 0.4871) / 32 * (h - l) for l, h in zip(low, high, strict=True)
        ]
        grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
        return float(self.query.inside(grid).mean() * np.prod(high - low))

    @property
    def is_convex(self) -> bool:
        """Whether the mesh is its own convex hull to a thousandth of the volume."""
        return self.closed and self.solid_volume >= 0.999 * self.hull.volume

    def triangles(self) -> Triangles:
        """The mesh itself."""
        return self.vertices, self.faces

    def depth(self, points: ArrayLike, *, threads: int = 1) -> Array:
        """How far points (n, 3) are inside [m], (n,): see `halfphysics.geometry.mesh_queries`."""
        return self.query.depth(as_array(points), threads=threads)
