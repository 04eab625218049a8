"""Starts in mid-air: detects clips with another floor height than the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene

#: Largest gap to a surface that still counts as standing on it [m]: shoes, noise, another stature.
FLOATING = 0.05
#: Parts that people stand, sit, kneel, lie and lean on.
_PARTS = tuple(
    JOINT_INDEX[name]
    for name in (
        *("left_foot", "right_foot", "left_ankle", "right_ankle", "left_knee", "right_knee"),
        *("pelvis", "spine3", "left_wrist", "right_wrist", "head"),
    )
)
_DOWN = (0.0, 0.0, -1.0)


def floating(body: Body, pose: Pose, scene: Scene) -> tuple[float, str] | None:
    """Height of the person over the nearest surface below [m], and the name of that surface.

    None: the person is supported, or nothing is below.

    Rays go down from the lowest skin vertex of each part that could bear a person.
    """
    vertices = body.vertices(pose)
    parts = body.weights.argmax(axis=1)
    best: tuple[float, str] | None = None
    for part in _PARTS:
        own = vertices[parts == part]
        if not len(own):
            continue
        hit = scene.ray(own[int(np.argmin(own[:, 2]))], _DOWN)
        if hit is None:
            continue
        if hit.distance <= FLOATING:
            return None
        if best is None or hit.distance < best[0]:
            best = hit.distance, hit.name
    return best
