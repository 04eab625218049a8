"""A person beside a robot in a MuJoCo world of one's own: `hp.attach`.

An arm with a servo swings into the way of a person who holds out an arm; how far each gives
depends on how stiff the person is and how strong the motor.
"""

from __future__ import annotations

import mujoco
import numpy as np

import halfphysics as hp

ARM = """
<mujoco>
  <option timestep="0.00333333333333333333" integrator="implicitfast"/>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="4 4 0.1"/>
    <body name="arm" pos="0.55 -1.0 1.4" euler="0 0 90">
      <joint name="shoulder" axis="0 0 1" damping="2"/>
      <geom name="arm" type="capsule" fromto="0 0 0 0.65 0 0" size="0.04" mass="4"/>
    </body>
  </worldbody>
  <actuator>
    <position name="shoulder" joint="shoulder" kp="300" dampratio="1" forcerange="-60 60"/>
  </actuator>
</mujoco>
"""


def main() -> dict[float, tuple[float, float]]:
    """Stiffness -> (largest turn of a joint away from the motion [rad], robot's angle [rad])."""
    sequence = hp.scenarios.load("walk_into_wall")
    still = sequence.motion[0]
    # Arms held out to the sides, where the robot swings.
    rotations = np.array(still.rotations)
    rotations[1:] = 0.0
    pose = hp.Pose(still.translation, rotations, still.axes)
    found = {}
    for stiffness in (0.0, 1.0, 10.0):
        spec = mujoco.MjSpec.from_string(ARM)
        human = hp.attach(spec)
        model = spec.compile()
        data = mujoco.MjData(model)
        person = human.bind(model, data, settings=hp.Settings(stiffness=stiffness))
        person.reset(pose)
        turned = 0.0
        for i in range(60):
            data.ctrl[0] = 1.0 * (i + 1) / 60
            person.step(pose, dt=1.0 / 60.0)
            away = person.pose.rotations[1:] - pose.rotations[1:]
            turned = max(turned, float(np.linalg.norm(away, axis=-1).max()))
        found[stiffness] = (turned, float(data.qpos[0]))
        print(
            f"stiffness {stiffness:g}: joints turned by {np.degrees(turned):.1f} degrees, the "
            f"robot got to {np.degrees(data.qpos[0]):.0f} of {np.degrees(data.ctrl[0]):.0f}"
        )
    return found


if __name__ == "__main__":
    main()
