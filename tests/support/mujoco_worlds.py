"""MuJoCo worlds for tests of people in them: a robot arm, scales, a ball."""

from __future__ import annotations

import mujoco
import numpy as np

import halfphysics as hp
from halfphysics.bench.robot_arm import robot_arm

#: Of the pelvis over the floor, the soles a centimetre off it; of the wrists over the pelvis [m].
HEIGHT, WRIST = hp.Body.default().variant.standing_height + 0.01, 0.48

FLOOR = '<geom name="floor" type="plane" size="5 5 0.1"/>'


def spec_of(
    x: float = 0.9, y: float = 0.0, force: float = 200.0, rub: int = 0, more: str = ""
) -> mujoco.MjSpec:
    """A floor and a robot arm at the height of the wrists; `more`: elements of the world."""
    place, world = f"{x} {y} {HEIGHT + WRIST}", FLOOR + more
    return mujoco.MjSpec.from_string(robot_arm(place, force=force, rubs=bool(rub), world=world))


def t_pose() -> hp.Pose:
    """Upright, facing -y, arms out along x."""
    rotations = np.zeros((55, 3))
    rotations[0] = (np.pi / 2.0, 0.0, 0.0)
    joints = hp.Body.default().rest_joints
    return hp.Pose(np.array([0.0, 0.0, HEIGHT]) - joints[0], rotations)
