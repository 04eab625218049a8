"""A person in a MuJoCo world of its own: `hp.attach`."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

import halfphysics as hp
from result_cases.case import Case
from result_cases.digests import TOUCHES
from result_cases.scenes import clip, moved, standing

#: A robot arm of two hinges on a stand, with position servos; a loose box, a ball and a bench.
ROBOT = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <geom name="bench" type="box" pos="0.1 -0.5 0.2" size="0.2 0.15 0.2"/>
    <body name="base" pos="-1.1 -0.45 1.35">
      <geom name="stand" type="cylinder" size="0.05 0.05" mass="5"/>
      <body name="upper">
        <joint name="yaw" axis="0 0 1" damping="2"/>
        <geom name="upper" type="capsule" fromto="0 0 0 0 0.35 0" size="0.04" mass="3"/>
        <body name="fore" pos="0 0.35 0">
          <joint name="elbow" axis="0 0 1" damping="1"/>
          <geom name="fore" type="capsule" fromto="0 0.1 0 0 0.35 0" size="0.035" mass="2"/>
        </body>
      </body>
    </body>
    <body name="crate" pos="0.15 -0.25 0.7"><freejoint/>
      <geom name="crate" type="box" size="0.1 0.1 0.1" mass="2"/></body>
    <body name="ball" pos="0.0 -0.3 1.6"><freejoint/>
      <geom name="ball" type="sphere" size="0.1" mass="1"/></body>
  </worldbody>
  <actuator>
    <position name="yaw" joint="yaw" kp="400" dampratio="1" forcerange="-200 200"/>
    <position name="elbow" joint="elbow" kp="200" dampratio="1" forcerange="-200 200"/>
  </actuator>
</mujoco>
"""
#: Length of a step of the world where a motion of 30 frames per second is followed [s].
STEP = 1.0 / 480.0


class World:
    """The world with a person in it, and what came of every step."""

    def __init__(self, **changes: Any) -> None:
        import mujoco

        spec = mujoco.MjSpec.from_string(ROBOT)
        human = hp.attach(spec)
        self.model = spec.compile()
        self.model.opt.timestep = STEP
        self.data = mujoco.MjData(self.model)
        self.data.qpos[0] = self.data.ctrl[0] = -0.5 * np.pi
        self.control = human.bind(self.model, self.data, settings=hp.Settings(**changes))
        self.seen: list[Any] = []

    def step(self, pose: hp.Pose, aim: float) -> None:
        """One frame of 1/30 s, in which the arm is told to go somewhere [rad]."""
        self.data.ctrl[0] = aim
        self.control.step(pose, dt=1.0 / 30.0)
        control, touched = self.control, self.control.contacts
        self.seen.append(
            {
                "pose": (control.pose.translation, control.pose.rotations),
                "world": (self.data.qpos, self.data.qvel),
                "contacts": [getattr(touched, name) for name in TOUCHES[0]],
                "torque": control.torque,
                "clearance": control.clearance,
            }
        )


def played(motion: hp.Motion, **changes: Any) -> dict[str, Any]:
    """The arm swings at a person who moves; halfway a state is saved, and at the end resumed."""
    import mujoco

    world = World(**changes)
    world.control.reset(motion[0])
    middle, last = len(motion) // 2, len(motion)
    kept: tuple[bytes, Any] = (b"", None)
    size = mujoco.mj_stateSize(world.model, mujoco.mjtState.mjSTATE_INTEGRATION)
    for t in range(1, last):
        if t == middle:
            kept = world.control.get_state(), np.zeros(size)
            mujoco.mj_getState(
                world.model, world.data, kept[1], mujoco.mjtState.mjSTATE_INTEGRATION
            )
        world.step(motion[t], -0.5 * np.pi + 1.2 * t / last)
    mujoco.mj_setState(world.model, world.data, kept[1], mujoco.mjtState.mjSTATE_INTEGRATION)
    world.control.set_state(kept[0])
    world.control.set_stiffness({"arms": 0.2})
    for t in range(middle, last):
        world.step(motion[t], 0.0)
    return {"names": world.control.names, "steps": world.seen, "state": kept[0]}


def kick(**changes: Any) -> dict[str, Any]:
    """`played` with a real kick."""
    return played(moved(clip("asap_kick1", seconds=1.0), (0.0, 0.0, 0.002)), **changes)


def lean(**changes: Any) -> dict[str, Any]:
    """`played` with a person who stands and leans forward."""
    return played(moved(standing(25, lean=0.9), (0.0, 0.0, 0.005)), **changes)


def cases() -> Iterator[Case]:
    """Two motions, every way to drive a hosted person."""
    for name, changes in {
        "default": {},
        "parts": {"contact": "parts"},
        "algorithm1": {"drive_time": None, "stiffness": 0.0},
        "human": {"strength": "human"},
        "firm": {"stiffness": 10.0, "contact": "parts"},
    }.items():
        yield Case(f"hosted/kick/{name}", partial(kick, **changes), name == "default")
        yield Case(f"hosted/lean/{name}", partial(lean, **changes), name == "parts")
