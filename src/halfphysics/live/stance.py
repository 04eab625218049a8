"""How a person stands whom nobody moves: upright, arms down, on what is below."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from halfphysics.motion.joint_groups import JOINT_GROUPS
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX, N_JOINTS
from halfphysics.results.moment import standing_still

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.scene.scene import Scene

#: Joints that go back to the stance when nobody sends them: legs and pelvis stay, so that somebody
#: who sits goes on sitting.
RELAXING = np.isin(
    np.arange(N_JOINTS),
    [JOINT_INDEX[j] for group in ("arms", "head", "trunk") for j in JOINT_GROUPS[group]],
)
#: Height from which the ground below a person is looked for [m]: below ceilings and table tops.
_LOOK_FROM = 1.0

_BENDS = {
    "left_shoulder": (0.0, 0.0, -1.25),
    "right_shoulder": (0.0, 0.0, 1.25),
    "left_elbow": (0.0, -0.25, 0.0),
    "right_elbow": (0.0, 0.25, 0.0),
}


def stance(body: Body, scene: Scene, x: float = 0.0, y: float = 0.0) -> Pose:
    """The pose of a person who stands at (x, y) [m] and looks along -y, soles on what is there.

    Without static geometry below, on z = 0.
    """
    rotations = np.zeros((N_JOINTS, 3))
    rotations[0] = (0.5 * np.pi, 0.0, 0.0)
    for joint, bend in _BENDS.items():
        rotations[JOINT_INDEX[joint]] = bend
    moving = [*scene.objects, *(n for item in scene.articulated.values() for n in item.link_names)]
    hit = scene.ray((x, y, _LOOK_FROM), (0.0, 0.0, -1.0), ignore=moving)
    ground = 0.0 if hit is None else float(hit.position[2])
    pelvis = body.rest_joints[0]
    here = Pose(np.array([x, y, 1.0]) - pelvis, rotations)
    placed = standing_still(here).grounded(body, ground)
    return Pose(placed.translation[0], rotations)
