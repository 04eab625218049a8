"""Sharp edges of a mesh: to draw them, and to shade a mesh smoothly between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.mesh_queries import components

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Faces = NDArray[np.int32]

# Vertices nearer than this are one [m]: many meshes have a copy of a vertex for each face.
_SAME = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Folds:
    """The edges of a mesh, with how they bend.

    Attributes:
        points: Vertices without copies (P, 3) [m].
        faces: Faces that have an area, indices into `points` (F, 3).
        normals: Unit normals of the faces (F, 3).
        sides: Ends of each edge that two faces share (E, 2).
        pairs: Those faces (E, 2).
        bend: Cosine of the angle between them (E,).
        lone: Ends of each edge of one face, or of more than two (L, 2).
    """

    points: Array
    faces: Ints
    normals: Array
    sides: Ints
    pairs: Ints
    bend: Array
    lone: Ints


def folds(vertices: Array, faces: NDArray[np.integer]) -> Folds:
    """The edges of a mesh (V, 3) [m], (F, 3)."""
    grid = np.round(np.asarray(vertices) / _SAME).astype(np.int64)
    _, kept, index = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    points = np.asarray(vertices, dtype=np.float64)[kept]
    own = index.reshape(-1)[np.asarray(faces)]
    corners = points[own]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    some = area > 0.0
    own, normals = own[some], normals[some] / area[some, None]
    sides = np.sort(np.concatenate([own[:, [0, 1]], own[:, [1, 2]], own[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(own)), 3)
    order = np.lexsort(sides.T)
    sides, owner = sides[order], owner[order]
    starts = np.ones(len(sides), dtype=bool)
    starts[1:] = (sides[1:] != sides[:-1]).any(axis=1)
    first = np.flatnonzero(starts)
    count = np.diff(np.append(first, len(sides)))
    two, other = first[count == 2], first[count != 2]
    pairs = np.stack([owner[two], owner[two + 1]], axis=1)
    return Folds(
        points=points,
        faces=own,
        normals=normals,
        sides=sides[two],
        pairs=pairs,
        bend=np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]]),
        lone=sides[other],
    )


def split(vertices: Array, faces: NDArray[np.integer], degrees: float) -> tuple[Array, Faces]:
    """The same surface with a vertex for each smooth side of an edge that bends by more.

    A renderer that gives each vertex one normal then shades it with sharp edges.

    Args:
        vertices: (V, 3) [m].
        faces: (F, 3).
        degrees: Edges that bend by less are smooth.
    """
    found = folds(vertices, faces)
    smooth = found.bend >= np.cos(np.radians(degrees))
    # The corners of two faces at each end of a smooth edge are one vertex.
    joined = []
    for end in (0, 1):
        at = found.sides[smooth, end]
        columns = [
            np.argmax(found.faces[found.pairs[smooth, k]] == at[:, None], axis=1) for k in (0, 1)
        ]
        joined.append(np.stack([3 * found.pairs[smooth, k] + columns[k] for k in (0, 1)], axis=1))
    corners = found.faces.size
    group = np.asarray(components(corners, np.concatenate(joined)))
    _, first, index = np.unique(group, return_index=True, return_inverse=True)
    return found.points[found.faces.reshape(-1)[first]], index.reshape(-1, 3).astype(np.int32)
