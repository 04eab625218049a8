"""A floor under people and things whose data set has none."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.base.reader_warnings import warn
from halfphysics.geometry.shapes import Plane

if TYPE_CHECKING:
    from halfphysics.simulation.sequence import Sequence

#: Name of the floor in the scene.
GROUND = "ground"
#: Things that stay farther above the lowest skin than this were never on the floor [m].
_NEAR = 0.1


def needs_ground(sequence: Sequence) -> bool:
    """Whether nobody stands on anything in a sequence's scene: GRAB has a table top only.

    What is as low as the lowest skin may be a floor, and so is what a person is over most of the
    time, whatever its height.
    """
    statics = sequence.scene.statics.values()
    if any(isinstance(static.shape, Plane) for static in statics):
        return False
    height = lowest_skin(sequence) if statics else 0.0
    for static in statics:
        corners = rot.rotate(static.quaternion, static.shape.triangles()[0]) + static.position
        low, high = corners.min(axis=0), corners.max(axis=0)
        if low[2] <= height + _NEAR:
            return False
        for motion in sequence.motions:
            at = motion.translation[:, :2]
            if np.median(((at > low[:2]) & (at < high[:2])).all(axis=1)):
                return False
    return True


def lowest_skin(sequence: Sequence) -> float:
    """Height of the lowest skin in all frames [m]."""
    from halfphysics.body.body import Body

    skins = [
        (Body.default() if body is None else body).vertices(motion)[..., 2].min()
        for motion, body in zip(sequence.motions, sequence.bodies, strict=True)
    ]
    return float(min(skins))


def add_ground(sequence: Sequence, path: Path, height: float | None = None) -> None:
    """Add a floor to a sequence's scene, under the lowest skin and the lowest of its objects.

    Args:
        sequence: With recorded objects, in a scene without a floor.
        path: The file, for the message.
        height: Where the floor is, if the caller says it [m].

    Warns:
        HalfPhysicsWarning: Where the floor is.
    """
    if height is not None:
        sequence.scene.add_static(GROUND, Plane(offset=height))
        return
    height = lowest_skin(sequence)
    for name, track in sequence.recorded.items():
        item = sequence.scene.objects.get(name)
        if item is None:
            continue
        corners = item.true_shape.triangles()[0]
        down = rot.to_matrix(track.quaternion)[:, 2]  # world z of its own axes
        low = float(np.min(track.position[:, 2] + (down @ corners.T).min(axis=1)))
        if abs(low - height) < _NEAR:
            height = min(height, low)
    sequence.scene.add_static(GROUND, Plane(offset=height))
    warn(
        f"{path}: nothing says where the floor is: one named {GROUND!r} is put under the lowest "
        f"skin and object, at {height:.3f} m (ground=False: none)"
    )
