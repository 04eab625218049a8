"""The robots: MJCF whose joints have springs, which are their motors.

A motor pulls its joint to where it is told with the joint's stiffness and damping, and with its
effort at most; robots bear their own weight (docs/envs.md, "Robots"). Metres, kilograms, radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: An arm on a pedestal, x ahead. Its links point up where all joints are 0; `lift`, `elbow` and
#: `wrist` bend it forward. The fingers slide apart along y: 0 is closed.
ARM_XML = """
<mujoco model="arm"><compiler angle="radian"/><worldbody>
<body name="pedestal"><geom type="box" size=".13 .13 .38" pos="0 0 .38" mass="40"/>
 <body name="turret" pos="0 0 .80">
  <joint name="pan" axis="0 0 1" range="-2.6 2.6" stiffness="900" damping="90" armature=".5"/>
  <geom type="cylinder" size=".08 .05" mass="4"/>
  <body name="upper" pos="0 0 .05">
   <joint name="lift" axis="0 1 0" range="-1.6 2.0" stiffness="900" damping="90" armature=".5"/>
   <geom type="capsule" fromto="0 0 .03 0 0 .42" size=".05" mass="3"/>
   <body name="fore" pos="0 0 .45">
    <joint name="elbow" axis="0 1 0" range="0 2.8" stiffness="600" damping="50" armature=".2"/>
    <geom type="capsule" fromto="0 0 .03 0 0 .37" size=".04" mass="2"/>
    <body name="hand" pos="0 0 .40">
     <joint name="wrist" axis="0 1 0" range="-2.8 2.8" stiffness="250" damping="12" armature=".05"/>
     <geom type="box" size=".02 .055 .03" pos="0 0 .02" mass=".5"/>
     <body name="left" pos="0 0 .1">
      <joint name="left" type="slide" axis="0 1 0" range="0 .06" stiffness="1500" damping="60"/>
      <geom type="box" size=".014 .008 .045" pos="0 .008 0" mass=".1"/></body>
     <body name="right" pos="0 0 .1">
      <joint name="right" type="slide" axis="0 -1 0" range="0 .06" stiffness="1500" damping="60"/>
      <geom type="box" size=".014 .008 .045" pos="0 -.008 0" mass=".1"/></body>
    </body></body></body></body></body>
</worldbody></mujoco>"""

#: A round base that goes anywhere in the plane and turns, x ahead, with a mast.
BASE_XML = """
<mujoco model="base"><compiler angle="radian"/><worldbody>
<body name="cart">
 <joint name="x" type="slide" axis="1 0 0" stiffness="4000" damping="900"/>
 <joint name="y" type="slide" axis="0 1 0" stiffness="4000" damping="900"/>
 <geom type="cylinder" size=".10 .05" pos="0 0 .12" mass="8" contype="0" conaffinity="0"/>
 <body name="base" pos="0 0 .02">
  <joint name="yaw" axis="0 0 1" stiffness="300" damping="60"/>
  <geom type="cylinder" size=".24 .14" pos="0 0 .15" mass="22"/>
  <geom type="cylinder" size=".05 .40" pos="0 0 .69" mass="4"/>
  <geom type="box" size=".06 .14 .06" pos=".02 0 1.13" mass="2"/>
 </body></body>
</worldbody></mujoco>"""

#: A base that holds doors: as `BASE_XML`, with a fork of two level fingers in front of it, around a
#: place 44 cm ahead and 1 m high, in which a handle stands with 13 mm of play to either side.
HOLDER_XML = """
<mujoco model="holder"><compiler angle="radian"/><worldbody>
<body name="cart">
 <joint name="x" type="slide" axis="1 0 0" stiffness="4000" damping="900"/>
 <joint name="y" type="slide" axis="0 1 0" stiffness="4000" damping="900"/>
 <geom type="cylinder" size=".10 .05" pos="0 0 .12" mass="8" contype="0" conaffinity="0"/>
 <body name="base" pos="0 0 .02">
  <joint name="yaw" axis="0 0 1" stiffness="500" damping="100"/>
  <geom type="cylinder" size=".20 .14" pos="0 0 .15" mass="22"/>
  <geom type="cylinder" size=".05 .36" pos="0 0 .65" mass="4"/>
  <geom type="capsule" fromto="0 .06 .98 .48 .06 .98" size=".014" mass="1"/>
  <geom type="capsule" fromto=".40 .06 .98 .40 -.06 .98" size=".012" mass=".1"/>
  <geom type="capsule" fromto=".48 .06 .98 .48 -.06 .98" size=".012" mass=".1"/>
 </body></body>
</worldbody></mujoco>"""
#: The middle of that fork ahead of the base [m].
FORK = 0.44


@dataclass(frozen=True)
class Arm:
    """Measures of `ARM_XML` [m], and its inverse kinematics."""

    shoulder: float = 0.85
    upper: float = 0.45
    fore: float = 0.40
    hand: float = 0.10
    #: The most that the motors exert [N m], of the fingers [N].
    effort: ClassVar[Mapping[str, float]] = {
        "pan": 90.0,
        "lift": 150.0,
        "elbow": 90.0,
        "wrist": 25.0,
        "left": 25.0,
        "right": 25.0,
    }
    #: Joints in the order of `reach`.
    joints: ClassVar[tuple[str, ...]] = ("pan", "lift", "elbow", "wrist")

    def reach(self, point: Array) -> Array:
        """Joint angles (N, 4) [rad] that put the middle between the fingers at points (N, 3) [m] of
        the robot's frame, the hand level and pointing outwards.

        Points out of reach are approached along the line from the shoulder.
        """
        x, y, z = point[:, 0], point[:, 1], point[:, 2]
        out, up = np.sqrt(x * x + y * y) - self.hand, z - self.shoulder
        far = np.sqrt(out * out + up * up)
        short = np.clip(far, abs(self.upper - self.fore) + 0.05, self.upper + self.fore - 0.01)
        cosine = (short * short - self.upper**2 - self.fore**2) / (2.0 * self.upper * self.fore)
        elbow = np.arccos(np.clip(cosine, -1.0, 1.0))
        inner = np.arctan2(self.fore * np.sin(elbow), self.upper + self.fore * np.cos(elbow))
        lift = np.arctan2(out, up) - inner
        wrist = 0.5 * np.pi - lift - elbow
        return np.stack([np.arctan2(y, x), lift, elbow, wrist], axis=1)


ARM = Arm()

#: The most that the motors of a base exert: x, y [N], yaw [N m].
BASE_EFFORT: Mapping[str, float] = {"x": 120.0, "y": 120.0, "yaw": 40.0}


def model_of(xml: str) -> Any:
    """A `mujoco.MjSpec` of our own MJCF: `Scene.add_articulated` reads it in this process, where
    text and files of strangers are read in one apart."""
    import mujoco

    return mujoco.MjSpec.from_string(xml)


def efforts(name: str, effort: Mapping[str, float]) -> dict[str, float]:
    """`Plan.motors` of a robot by its name in the scene."""
    return {f"{name}/{joint}": most for joint, most in effort.items()}
