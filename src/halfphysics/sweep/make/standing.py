"""Supports in a scene: an item that is raised carries the items that stand on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.articulated import Articulated, start_poses
from halfphysics.scene.items import Object, Static
from halfphysics.scene.scene import Scene
from halfphysics.scene.trajectories import KinematicObject
from halfphysics.sweep.make.scaled import lowest

Array = NDArray[np.float64]

#: An item stands on a support up to this height above or depth below its surface [m].
NEAR = 0.02


@dataclass(frozen=True)
class Support:
    """The support of an item.

    Attributes:
        name: Name of the static or object beneath.
        height: Height of its surface there above its lowest point [m]; 0 for a plane.
    """

    name: str
    height: float


@dataclass(frozen=True)
class _Extent:
    """Bounding box of an item in the world, `low` and `high` (3,) [m]."""

    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        return 0.5 * (self.low + self.high)


def supports(scene: Scene) -> dict[str, Support]:
    """The support of every item that stands on a static or an object.

    The support is the first item straight below the centre of the bounding box, within `NEAR` of
    the lowest point; otherwise the first item whose top is within `NEAR` and whose centre is below
    the item (a leg below a table top). Kinematic objects have no support; articulated objects
    support nothing.
    """
    items: dict[str, Static | Object] = {**scene.statics, **scene.objects}
    extents = {
        name: _extent(rot.rotate(item.quaternion, item.mesh()[0]) + item.position, item)
        for name, item in items.items()
        if not isinstance(item.shape, Plane)
    }
    found = {
        name: _beneath(scene, extents, extent, name)
        for name, extent in extents.items()
        if not isinstance(items[name], KinematicObject)
    }
    for name, jointed in scene.articulated.items():
        vertices = _vertices(jointed)
        if len(vertices):
            extent = _Extent(vertices.min(axis=0), vertices.max(axis=0))
            found[name] = _beneath(scene, extents, extent, name)
    return {name: support for name, support in found.items() if support is not None}


def _beneath(
    scene: Scene, extents: Mapping[str, _Extent], mine: _Extent, name: str
) -> Support | None:
    bottom = float(mine.low[2])
    # Only an item with a lower bottom can be a support: no two items support each other.
    above = [n for n, other in extents.items() if n == name or other.low[2] >= bottom]
    start = (mine.middle[0], mine.middle[1], bottom + NEAR)
    links = [link for item in scene.articulated.values() for link in item.link_names]
    hit = scene.ray(start, (0.0, 0.0, -1.0), ignore=[*above, *links])
    if hit is not None and hit.distance <= 2.0 * NEAR:
        plane = hit.name not in extents
        foot = hit.position[2] if plane else extents[hit.name].low[2]
        return Support(hit.name, float(hit.position[2] - foot))
    for other, its in extents.items():
        under = (np.abs(its.middle - mine.middle) <= 0.5 * (mine.high - mine.low))[:2].all()
        if other not in above and under and abs(its.high[2] - bottom) <= NEAR:
            return Support(other, float(its.high[2] - its.low[2]))
    return None


def _extent(vertices: Array, item: Static | Object) -> _Extent:
    """Bounding box of a collision shape; its bottom is exact, also for round shapes."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    low[2] = item.position[2] + lowest(item)
    return _Extent(low, high)


def _vertices(item: Articulated) -> Array:
    """Vertices (n, 3) [m] of all collision shapes, in the world, at the start."""
    placed = [
        rot.rotate(quaternion, link.mesh()[0]) + position
        for link, (position, quaternion) in zip(item.links, start_poses(item), strict=True)
    ]
    return np.concatenate(placed or [np.zeros((0, 3))])
