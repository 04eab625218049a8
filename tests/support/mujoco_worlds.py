"""MuJoCo worlds for tests of people in them: a robot arm, scales, a ball."""

from __future__ import annotations

import mujoco
import numpy as np

import halfphysics as hp

#: Of the pelvis over the floor, the soles a centimetre off it; of the wrists over the pelvis [m].
HEIGHT, WRIST = hp.Body.default().variant.standing_height + 0.01, 0.48

#: A robot arm of two hinges on a stand, with position servos of limited force.
ARM = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="base" pos="{x} {y} {z}">
      <geom name="stand" type="cylinder" size="0.05 0.05" mass="5"
        contype="{rub}" conaffinity="{rub}"/>
      <body name="upper">
        <joint name="yaw" axis="0 0 1" damping="2"/>
        <geom name="upper" type="capsule" fromto="0 0 0 0 0.35 0" size="0.04" mass="3"/>
        <body name="fore" pos="0 0.35 0">
          <joint name="elbow" axis="0 0 1" damping="1"/>
          <geom name="fore" type="capsule" fromto="0 0.1 0 0 0.35 0" size="0.035" mass="2"/>
        </body>
      </body>
    </body>
    {more}
  </worldbody>
  <actuator>
    <position name="yaw" joint="yaw" kp="400" dampratio="1" forcerange="-{force} {force}"/>
    <position name="elbow" joint="elbow" kp="200" dampratio="1" forcerange="-{force} {force}"/>
  </actuator>
</mujoco>
"""


def spec_of(
    x: float = 0.9, y: float = 0.0, force: float = 200.0, rub: int = 0, more: str = ""
) -> mujoco.MjSpec:
    text = ARM.format(x=x, y=y, z=HEIGHT + WRIST, force=force, rub=rub, more=more)
    return mujoco.MjSpec.from_string(text)


def t_pose() -> hp.Pose:
    """Upright, facing -y, arms out along x."""
    rotations = np.zeros((55, 3))
    rotations[0] = (np.pi / 2.0, 0.0, 0.0)
    joints = hp.Body.default().rest_joints
    return hp.Pose(np.array([0.0, 0.0, HEIGHT]) - joints[0], rotations)
