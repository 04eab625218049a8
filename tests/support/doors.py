"""A door as MJCF, and its place in the way of a person who walks along x."""

import numpy as np

DOOR = """<mujoco><worldbody><body name="frame">
<geom type="box" pos="-0.06 0 1" size=".03 .05 1"/>
<body name="panel">
  <joint name="hinge" axis="0 0 1" range="-5 100" damping="0.5"/>
  <geom type="box" pos=".45 0 1" size=".44 .02 .98" mass="20"/>
  <geom type="sphere" pos=".85 -.05 1" size=".03" mass=".1"/>
  <geom type="box" pos=".45 0 1" size=".6 .1 1" contype="0" conaffinity="0" mass="0"/>
</body></body></worldbody></mujoco>"""


#: The hinge is at the side of a person who walks along x.
ACROSS = {"position": (0.7, 0.6, 0.03), "quaternion": (np.sqrt(0.5), 0, 0, -np.sqrt(0.5))}
