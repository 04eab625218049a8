"""A part of a mesh, cut along the zero line of a field: its border is smooth, no zigzag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Faces = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True, eq=False)
class Cut:
    """A part of a mesh. Its vertices are vertices of the mesh, and points on its edges.

    Attributes:
        ends: Vertices of the mesh between which each vertex of the part lies (N, 2).
        share: Its place between them (N,): 0 at the first, 1 at the second.
        faces: Faces of the part, indices into its own vertices (M, 3).
    """

    ends: Ints
    share: Array
    faces: Faces

    def of(self, values: Array) -> Array:
        """Values at the part's vertices (N, ...) from those at the mesh's (V, ...)."""
        share = self.share.reshape(-1, *(1,) * (values.ndim - 1))
        first, second = values[self.ends[:, 0]], values[self.ends[:, 1]]
        result: Array = first + share * (second - first)
        return result


def cut(field: Array, faces: NDArray[np.integer]) -> Cut:
    """The part of a mesh on which a field is not negative.

    Two parts cut with a field and its negative meet without a gap.

    Args:
        field: Values at the vertices (V,); linear in the faces.
        faces: (F, 3).
    """
    inside = field >= 0.0
    count = inside[faces].sum(axis=1)
    whole = faces[count == 3]
    # Rotate the corners so that the only vertex on its side of the line comes first.
    crossed = []
    for alone in (1, 2):
        some = faces[count == alone]
        first = np.argmax(inside[some] == (alone == 1), axis=1)
        crossed.append(np.take_along_axis(some, (first[:, None] + np.arange(3)) % 3, axis=1))
    tips, stumps = crossed
    pairs = np.concatenate([c[:, [0, k]] for c in crossed for k in (1, 2)])
    pairs = np.sort(pairs, axis=1)
    edges, index = np.unique(pairs, axis=0, return_inverse=True)
    index = index.reshape(-1) + len(field)
    a, b = field[edges[:, 0]], field[edges[:, 1]]
    t, s = len(tips), len(stumps)
    tip_1, tip_2, stump_1, stump_2 = np.split(index, [t, 2 * t, 2 * t + s])
    out = np.concatenate(
        [
            whole,
            np.stack([tips[:, 0], tip_1, tip_2], axis=1),
            np.stack([stump_1, stumps[:, 1], stumps[:, 2]], axis=1),
            np.stack([stump_1, stumps[:, 2], stump_2], axis=1),
        ]
    )
    used, out = np.unique(out, return_inverse=True)
    corners = np.arange(len(field))
    ends = np.concatenate([np.stack([corners, corners], axis=1), edges])
    share = np.concatenate([np.zeros(len(field)), a / (a - b)])
    return Cut(ends=ends[used], share=share[used], faces=out.reshape(-1, 3).astype(np.int32))
