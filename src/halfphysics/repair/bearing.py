"""Frames in which the feet bear nobody: somebody sits, lies or kneels on furniture.

Feet of somebody on a bar stool hang over the floor, at rest, and are the lowest of the person: by
themselves they look like those of a clip that floats.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.geometry.shapes import Plane
from halfphysics.metrics.surface_gaps import carrying_gaps
from halfphysics.motion.skeleton import JOINT_INDEX

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Feet do not bear where other skin is nearer to what carries it by more than this [m]. Inside is
#: as near as on it: cushions give way, and estimators put people into seats.
NEARER = 0.01
#: Skin that bears: not that of the feet, which is asked about, and not that of arms, which lean on
#: tables, and in them, while somebody stands.
BEARS = (
    *("pelvis", "left_hip", "right_hip", "left_knee", "right_knee", "spine1", "spine2", "spine3"),
    *("neck", "head", "left_collar", "right_collar", "left_shoulder", "right_shoulder"),
)
# Every so many vertices of that skin are measured.
_SPARSE = 5


def borne_elsewhere(
    motion: Motion, body: Body, scene: Scene, objects: Mapping[str, Any], gap: Array
) -> Mask:
    """Frames (T,) in which skin other than the feet is nearer to what carries it than they are.

    Level ground is left out: of a clip that tilts, soles and other skin are not told apart by it.

    Args:
        motion: T frames.
        body: The person's body.
        scene: Statics and objects.
        objects: Tracks of the objects.
        gap: Of the parts of the feet from what is below (T, n) [m].
    """
    none = np.zeros(len(motion), dtype=bool)
    level = {name for name, its in scene.statics.items() if isinstance(its.shape, Plane)}
    if not objects and len(level) == len(scene.statics):
        return none
    part = np.argmax(body.weights, axis=1)
    group = np.full(len(part), -1)
    its = np.flatnonzero(np.isin(part, [JOINT_INDEX[name] for name in BEARS]))[::_SPARSE]
    if not len(its):
        return none
    group[its] = 0
    found = carrying_gaps(motion, body, scene, group, objects=objects)
    bears = np.array([*(name not in level for name in found.names), False])
    near = np.where(bears[found.item[:, 0]], found.gap[:, 0], np.inf)
    result: Mask = gap.min(axis=1) > np.maximum(near, 0.0) + NEARER
    return result
