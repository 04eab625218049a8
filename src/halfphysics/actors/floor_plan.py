"""What stands on the floor, from above: points of the surfaces that a walking person would meet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Plane

if TYPE_CHECKING:
    from halfphysics.actors.seen import Placed, Seen
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]

#: Distance of points on a surface [m].
SPACING = 0.06
# Heights between which a surface is in the way [m].
_LOW, _HIGH = 0.04, 1.9
# A person who stands in the way is as wide as this [m].
_PERSON = 0.3
_ROUND = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)
_CIRCLE = np.stack([np.cos(_ROUND), np.sin(_ROUND)], axis=1)


class FloorPlan:
    """Points in the way, on the floor (n, 2) [m].

    Planes are not among them: a scene's walls are boxes or meshes. Links of articulated objects are
    not, either.

    Args:
        scene: Whose statics stand where they are, and whose objects are looked for; None: no
            scene is known, and only people are in the way.
    """

    def __init__(self, scene: Scene | None) -> None:
        statics = () if scene is None else scene.statics.values()
        fixed = [_standing(static) for static in statics if not isinstance(static.shape, Plane)]
        self._tree = _tree(_in_the_way(fixed))
        objects: Mapping[str, Any] = {} if scene is None else scene.objects
        self._objects = {
            name: surface_points(*item.true_shape.triangles()) for name, item in objects.items()
        }

    def moving(self, seen: Seen, people: Iterable[Array] = ()) -> Array:
        """Points (m, 2) of what may be elsewhere by now; not of what the person holds itself.

        Args:
            seen: Objects as they are.
            people: Places that somebody stands at, (x, y) [m].
        """
        objects: Mapping[str, Placed] = seen.objects
        found = [
            _placed(points, *objects[name])
            for name, points in self._objects.items()
            if name in objects and name not in seen.held
        ]
        circles = [np.asarray(at) + _PERSON * _CIRCLE for at in people]
        return np.concatenate([_in_the_way(found), *circles])

    def clearance(self, places: Array, moving: Array) -> Array:
        """Distance of places (n, 2) from the nearest point in the way (n,) [m]."""
        out: Array = np.full(len(places), np.inf)
        for tree in (self._tree, _tree(moving)):
            if tree is not None:
                near: Array = np.asarray(tree.query(places)[0], dtype=np.float64)
                out = np.asarray(np.minimum(out, near), dtype=np.float64)
        return out


def surface_points(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Points (n, 3) on triangles, no farther from each other than `SPACING`.

    Rows parallel to a triangle's longest edge, each with as many points as it is long: a long thin
    triangle has few.
    """
    corners = np.asarray(vertices, dtype=np.float64)[faces].reshape(-1, 3, 3)
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    first = edges.argmax(axis=1) if len(edges) else np.zeros(0, dtype=int)
    each = np.arange(len(corners))
    a, b, top = (corners[each, (first + k) % 3] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, top - a), axis=1)
    height = area / np.maximum(edges[each, first], 1e-12)
    of, up = _divided(height)
    left, right = a[of] + up * (top - a)[of], b[of] + up * (top - b)[of]
    row, along = _divided(np.linalg.norm(right - left, axis=1))
    out: Array = left[row] + along * (right - left)[row]
    return out


def _divided(lengths: Array) -> tuple[NDArray[np.int64], Array]:
    """Of lines of some lengths (n,) [m], points at most `SPACING` apart, both ends included.

    Returns:
        For each point the number of its line (k,), and its share of the way (k, 1).
    """
    parts = np.maximum(1, np.ceil(lengths / SPACING - 1e-9)).astype(np.int64)
    line = np.repeat(np.arange(len(parts)), parts + 1)
    nth = np.arange(len(line)) - np.repeat(np.cumsum(parts + 1) - (parts + 1), parts + 1)
    return line, (nth / parts[line])[:, None]


def _standing(static: Any) -> Array:
    """Points (n, 3) on a static's triangles; of those above and below people, such as a floor of a
    hundred metres, none."""
    vertices, faces = static.shape.triangles()[:2]
    placed = _placed(np.asarray(vertices, dtype=np.float64), static.position, static.quaternion)
    heights = placed[faces][:, :, 2]
    return surface_points(
        placed, faces[(heights.max(axis=1) > _LOW) & (heights.min(axis=1) < _HIGH)]
    )


def _placed(points: Array, position: Array, quaternion: Array) -> Array:
    return np.asarray(position) + rot.rotate(quaternion, points)


def _in_the_way(groups: list[Array]) -> Array:
    """Of points (n, 3), those at the heights of a person, (m, 2), one a cell of half `SPACING`."""
    if not groups:
        return np.zeros((0, 2))
    points = np.concatenate(groups)
    points = points[(points[:, 2] > _LOW) & (points[:, 2] < _HIGH)]
    cells = np.unique(np.rint(points[:, :2] / (0.5 * SPACING)).astype(np.int64), axis=0)
    return np.asarray(cells * (0.5 * SPACING), dtype=np.float64)


def _tree(points: Array) -> Any:
    if not len(points):
        return None
    from scipy.spatial import cKDTree

    return cKDTree(points)
