"""What stands on what in a scene: so that what is raised carries what stands on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.articulated import Articulated, start_poses
from halfphysics.moving import Moving
from halfphysics.scene import Scene
from halfphysics.sweep.scaled import lowest
from halfphysics.things import Object, Static

Array = NDArray[np.float64]

#: What is no farther than this above something [m], or below its surface, stands on it.
NEAR = 0.02


@dataclass(frozen=True)
class Support:
    """What something stands on.

    Attributes:
        name: Of the static or object beneath.
        height: Of its surface there over its lowest point [m]; 0 on a plane.
    """

    name: str
    height: float


def supports(scene: Scene) -> dict[str, Support]:
    """Of everything that stands on a static or an object: on which.

    It is the first thing straight below the middle of the lowest points' bounding box, within
    `NEAR`. Things that move as told stand on nothing; nothing stands on an articulated object.
    """
    things: dict[str, Static | Object] = {**scene.statics, **scene.objects}
    low = {name: float(thing.position[2]) + lowest(thing) for name, thing in things.items()}
    found = {}
    for name, thing in things.items():
        if not isinstance(thing, Moving) and np.isfinite(low[name]):
            found[name] = _beneath(scene, low, _middle(thing), low[name], name)
    for name, jointed in scene.articulated.items():
        corners = _corners(jointed)
        if len(corners):
            middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
            found[name] = _beneath(scene, low, middle, float(corners[:, 2].min()), name)
    return {name: support for name, support in found.items() if support is not None}


def _beneath(
    scene: Scene, low: Mapping[str, float], middle: Array, bottom: float, name: str
) -> Support | None:
    # Only what reaches lower can carry: no two things carry each other.
    above = [other for other, z in low.items() if other == name or z >= bottom]
    start = (middle[0], middle[1], bottom + NEAR)
    hit = scene.ray(start, (0.0, 0.0, -1.0), ignore=above)
    if hit is None or hit.distance > 2.0 * NEAR:
        return None
    foot = low[hit.name]
    return Support(hit.name, float(hit.position[2]) - foot if np.isfinite(foot) else 0.0)


def _middle(thing: Static | Object) -> Array:
    corners = rot.rotate(thing.quaternion, thing.mesh()[0]) + thing.position
    return 0.5 * (corners.min(axis=0) + corners.max(axis=0))


def _corners(thing: Articulated) -> Array:
    """Vertices (n, 3) [m] of all that touches, in the world, where it starts."""
    placed = [
        rot.rotate(quaternion, link.mesh()[0]) + position
        for link, (position, quaternion) in zip(thing.links, start_poses(thing), strict=True)
    ]
    return np.concatenate(placed or [np.zeros((0, 3))])
