"""An arm beside a person in a MuJoCo world: momentum and touch over thousands of steps.

    PYTHONPATH=src:tests python -m campaigns.hosted [--steps 10000] [--contact skin]

One line: in how many steps they touched, and the largest of each figure.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import mujoco
import numpy as np

import halfphysics as hp
from halfphysics.bench.robot_arm import robot_arm
from support.mujoco_worlds import FLOOR, HEIGHT, WRIST, t_pose

#: Largest imbalance of momentum [N s], [N m s], over a run and in a step.
BALANCE = 1e-9

ARM = robot_arm(
    f"-1.1 -0.45 {HEIGHT + WRIST}",
    fore='<site name="pad" type="box" pos="0 0.2 0" size="0.1 0.4 0.1"/>',
    world=FLOOR,
    more='<sensor><touch site="pad"/></sensor>',
)
_ALL = mujoco.mjtState.mjSTATE_INTEGRATION


@dataclass
class Balance:
    """What came of a run.

    Attributes:
        steps, touched: Timesteps, and those in which arm and person touched.
        exchanged: Sum of the impulses' lengths [N s].
        run: Imbalance of the momentum of arm and person, summed over the run [N s].
        step: The same of one step, at its largest [N s].
        joints: Largest difference, in a step, of what the arm's joints gained over MuJoCo's own
            step from what the contacts' impulses give them, M^ (v - v*) - sum J^T p [N m s].
        touch: Largest difference of the touch sensor from the contacts' normal forces [N].
    """

    steps: int = 0
    touched: int = 0
    exchanged: float = 0.0
    run: float = 0.0
    step: float = 0.0
    joints: float = 0.0
    touch: float = 0.0


def balance(steps: int, contact: str = "skin") -> Balance:
    """The arm swings to and fro against the person's right forearm."""
    spec = mujoco.MjSpec.from_string(ARM)
    human = hp.attach(spec)
    model = spec.compile()
    data, free = mujoco.MjData(model), mujoco.MjData(model)
    control = human.bind(model, data, settings=hp.Settings(contact=contact))
    data.qpos[0] = data.ctrl[0] = -0.5 * np.pi
    pose, h = t_pose(), model.opt.timestep
    control.reset(pose)
    state, out = np.zeros(mujoco.mj_stateSize(model, _ALL)), Balance(steps=steps)
    total = np.zeros(3)
    for i in range(steps):
        mujoco.mj_getState(model, data, state, _ALL)
        mujoco.mj_setState(model, free, state, _ALL)
        free.xfrc_applied[:] = 0.0
        data.ctrl[0] = free.ctrl[0] = -0.5 * np.pi + 0.8 * np.sin(2.0 * h * i)
        control.step(pose)
        person = control.contacts.impulse.sum(axis=0)
        apart = person + h * data.xfrc_applied[:, :3].sum(axis=0)
        total += apart
        out.step = max(out.step, float(np.abs(apart).max()))
        out.exchanged += float(np.linalg.norm(person))
        rows = control.contact
        if not len(rows):
            continue
        out.touched += 1
        out.touch = max(out.touch, abs(float(data.sensordata[0] - rows.force[:, 0].sum())))
        out.joints = max(out.joints, _joints(model, data, free, rows))
    out.run = float(np.abs(total).max())
    return out


def _joints(model: mujoco.MjModel, data: mujoco.MjData, free: mujoco.MjData, rows: object) -> float:
    mujoco.mj_step(model, free)
    h = model.opt.timestep
    change, gained, jacobian = data.qvel - free.qvel, np.zeros(model.nv), np.zeros((3, model.nv))
    mujoco.mj_mulM(model, free, gained, change)
    gained += h * model.dof_damping * change
    for row, force in zip(rows, rows.world_force, strict=True):
        mujoco.mj_jac(model, free, jacobian, None, row.pos, model.geom_bodyid[row.geom1])
        gained += h * jacobian.T @ force
    return float(np.abs(gained).max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--contact", choices=("skin", "parts"), default="skin")
    arguments = parser.parse_args()
    print(balance(arguments.steps, arguments.contact))


if __name__ == "__main__":
    main()
