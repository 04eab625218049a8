"""A ragdoll: the same body in MuJoCo, driven up to a moment, then passive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.baselines.engine.following import by_velocity
from halfphysics.baselines.engine.model import EngineModel
from halfphysics.settings import Settings
from halfphysics.simulation.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.sequence import Sequence

#: MuJoCo steps per frame, and the factor for a passive body: chains of loose ball joints are less
#: stable than driven ones.
SUBSTEPS, _FINER = 8, 5
#: Damping of a limp joint [N m s/rad], of the order of relaxed elbows and knees.
DAMPING = 0.1


def let_go(sequence: Sequence, frame: int) -> Motion:
    """The motion of a person that goes limp at a frame: gravity acts, joints only have damping.

    Up to that frame it is followed by velocities, as with `halfphysics.baselines.EngineVelocity`.
    """
    import mujoco

    motion, dt = sequence.motions[0], 1.0 / sequence.motions[0].fps
    body = sequence.bodies[0]
    world = Simulator(sequence.scene, body=body, settings=Settings(), fps=motion.fps).world
    engine = EngineModel(world, dt / SUBSTEPS, mocap=False)
    data: Any = mujoco.MjData(engine.model)
    data.qpos[:], data.qvel[:] = engine.start()
    follow = by_velocity(engine, data, [motion], SUBSTEPS, dt)
    found = [np.array(data.qpos)]
    for t in range(1, len(motion)):
        if t <= frame:
            follow(t, None)
        else:
            if t == frame + 1:
                _loosen(engine.model, data)
            mujoco.mj_step(engine.model, data, SUBSTEPS * _FINER)
        found.append(np.array(data.qpos))
    (person,) = engine.people
    return motion.with_frames(*person.pose(np.array(found), motion.axes))


def _loosen(model: Any, data: Any) -> None:
    """Switch the drives off; the joints keep their damping."""
    import mujoco

    data.qfrc_applied[:] = 0.0
    model.opt.timestep /= _FINER
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    balls = model.jnt_type == mujoco.mjtJoint.mjJNT_BALL
    for dof in model.jnt_dofadr[balls]:
        model.dof_damping[dof : dof + 3] = DAMPING
