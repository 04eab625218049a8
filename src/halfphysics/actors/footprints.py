"""Where the feet of a pose are, seen from above."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from halfphysics.actors.foot import Foothold
from halfphysics.actors.stride import SIGN
from halfphysics.actors.walker import SIDES
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scenarios.acting.gait import TOES_OUT

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.pose import Pose


def feet_of(pose: Pose, body: Body) -> tuple[Foothold, Foothold]:
    """Footholds of the left and the right foot as they are in a pose."""
    positions, quaternions = body.joint_frames(pose)
    found = []
    for side in SIDES:
        ankle = JOINT_INDEX[f"{side}_ankle"]
        x, y, _ = positions[ankle]
        ahead = rot.rotate(quaternions[ankle], np.array([0.0, 0.0, 1.0]))
        yaw = math.atan2(ahead[1], ahead[0]) - SIGN[side] * float(TOES_OUT)
        found.append(Foothold(float(x), float(y), yaw))
    return found[0], found[1]
