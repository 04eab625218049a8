"""Dents for formats of animated scenes: the moving surface, and the few shapes that make it up.

Formats with morph targets have weights over time for a few shapes: with the depths D (T, m) of the
frames and, scaled, the changes of the normals N (T, 3 w), the singular value decomposition of
[D, N] (`halfphysics.results.low_rank`) gives both, so that positions and shading agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.render.result_meshes import CREASE
from halfphysics.results.low_rank import low_rank
from halfphysics.writers.normals import creased, vertex_normals

if TYPE_CHECKING:
    from halfphysics.results.dents import Dent

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Largest error of a vertex [m]: less than a pixel of a picture that shows a sofa.
TOLERANCE = 5e-4
#: Most shapes of one surface, and most numbers of all of them: 4 bytes each.
MOST_SHAPES, MOST_NUMBERS = 64, 6_000_000
# A change of a unit normal by 1 counts as this depth [m].
_NORMAL = 0.005


@dataclass(frozen=True, kw_only=True, eq=False)
class MovingSurface:
    """A dent's surface with separate vertices on both sides of its sharp edges.

    Attributes:
        dent: The dent.
        faces: (F, 3).
        own: The vertex of the dent's layer that each is (W,).
    """

    dent: Dent
    faces: Ints
    own: Ints

    @property
    def vertices(self) -> Array:
        """Vertices (W, 3) [m] where nothing presses."""
        return self.dent.layer.surface[self.own]

    def at(self, frame: int) -> tuple[Array, Array]:
        """Vertices (W, 3) [m] and unit normals (W, 3) in a frame."""
        vertices = self.dent.at(frame)[self.own]
        return vertices, vertex_normals(vertices, self.faces)

    @property
    def way(self) -> Array:
        """Where a vertex goes for each metre that it gives (W, 3)."""
        result: Array = self.dent.layer.way[self.own]
        return result

    @property
    def turning(self) -> Ints:
        """The vertices whose normals ever change: those of faces of which a vertex gives."""
        gives = np.isin(self.own, self.dent.vertices)
        return np.unique(self.faces[gives[self.faces].any(axis=1)])


def moving_surface(dent: Dent) -> MovingSurface:
    """The surface of a dent as formats with one normal for each vertex need it."""
    layer = dent.layer
    _, faces, _ = creased(layer.surface, layer.faces, CREASE)
    own = np.zeros(int(faces.max()) + 1, dtype=np.int64)
    own[faces.ravel()] = layer.faces.ravel()
    return MovingSurface(dent=dent, faces=faces.astype(np.int64), own=own)


def dent_shapes(moving: MovingSurface) -> tuple[Array, Array, Array]:
    """Shapes and weights: in every frame, weights @ shapes is what a surface moves by.

    Returns:
        Offsets of vertices (k, W, 3) [m] and of normals (k, W, 3), for weights of 1, and the
        weights (T, k), of which the largest of each shape is 1 or -1.
    """
    dent, turning = moving.dent, moving.turning
    rest = vertex_normals(moving.vertices, moving.faces)[turning]

    def turned(frames: NDArray[np.integer]) -> Array:
        change = np.stack([moving.at(frame)[1][turning] - rest for frame in frames.tolist()])
        return _NORMAL * change.reshape(len(frames), -1)

    most = min(MOST_SHAPES, max(MOST_NUMBERS // (6 * len(moving.own)), 1))
    weights, depth, normal = low_rank(dent.depth, TOLERANCE, most, turned)
    whole = np.zeros((len(depth), len(dent.layer.surface)))
    whole[:, dent.vertices] = depth
    offsets = whole[:, moving.own, None] * moving.way
    normals = np.zeros((len(depth), len(moving.own), 3))
    normals[:, turning] = normal.reshape(len(depth), -1, 3) / _NORMAL
    return offsets, normals, weights
