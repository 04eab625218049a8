"""A body whose segments are boxes, each rigid with one joint: volumes and contacts by hand."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from halfphysics.motion.skeleton import JOINT_INDEX

#: Corners of a unit box about the origin, and its triangles, outward.
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
TRIANGLES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


class BoxPerson:
    """Boxes at places that a test chooses: `skins` (T, V, 3) are the frames of any motion."""

    def __init__(self, sizes: Mapping[str, tuple[float, float, float]]) -> None:
        self.names = tuple(sizes)
        self.faces = np.concatenate([TRIANGLES + 8 * k for k in range(len(sizes))])
        self.rest_vertices = np.concatenate([CORNERS * size for size in sizes.values()])
        self.weights = np.zeros((8 * len(sizes), 55))
        for k, name in enumerate(sizes):
            self.weights[8 * k : 8 * k + 8, JOINT_INDEX[name]] = 1.0

    def placed(self, places: Mapping[str, tuple[float, float, float]]) -> np.ndarray:
        """Vertices (V, 3) with the middles of the boxes at these places [m]."""
        shifts = np.concatenate([np.tile(places[name], (8, 1)) for name in self.names])
        return self.rest_vertices + shifts


def box_person(sizes: Mapping[str, tuple[float, float, float]]) -> BoxPerson:
    """A body of boxes: joint -> size [m]."""
    return BoxPerson(sizes)
