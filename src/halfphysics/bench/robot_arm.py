"""A robot arm as text for MuJoCo: two hinges on a stand, with position servos of limited force."""

from __future__ import annotations

#: MuJoCo's default timestep [s].
TIMESTEP = 0.002

_ARM = """
<mujoco>
  <option timestep="{timestep}" integrator="implicitfast"/>
  <worldbody>
    <body name="base" pos="{place}">
      <geom name="stand" type="cylinder" size="0.05 0.05" mass="5"
        contype="{rubs}" conaffinity="{rubs}"/>
      <body name="upper">
        <joint name="yaw" axis="0 0 1" damping="2"/>
        <geom name="upper" type="capsule" fromto="0 0 0 0 0.35 0" size="0.04" mass="3"/>
        <body name="fore" pos="0 0.35 0">
          <joint name="elbow" axis="0 0 1" damping="1"/>
          <geom name="fore" type="capsule" fromto="0 0.1 0 0 0.35 0" size="0.035" mass="2"/>
          {fore}
        </body>
      </body>
    </body>
    {world}
  </worldbody>
  <actuator>
    <position name="yaw" joint="yaw" kp="400" dampratio="1" forcerange="-{force} {force}"/>
    <position name="elbow" joint="elbow" kp="200" dampratio="1" forcerange="-{force} {force}"/>
  </actuator>
  {more}
</mujoco>
"""


def robot_arm(
    place: str,
    *,
    force: float = 60.0,
    rubs: bool = False,
    fore: str = "",
    world: str = "",
    more: str = "",
) -> str:
    """The MJCF of a world with the arm.

    Args:
        place: Position of its base, "x y z" [m].
        force: The most that a servo exerts [N m].
        rubs: Whether its stand collides.
        fore: Elements that the forearm has besides.
        world: Elements that stand in the world besides.
        more: Elements of the model besides, such as sensors.
    """
    return _ARM.format(
        timestep=TIMESTEP,
        place=place,
        force=force,
        rubs=int(rubs),
        fore=fore,
        world=world,
        more=more,
    )
