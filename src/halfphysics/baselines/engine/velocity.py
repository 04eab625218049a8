"""A motion followed in plain MuJoCo by velocities, as one would write it by hand.

Each frame sets the velocities that lead to the target (Half-Physics, Algorithm 1: joints and root
rotation from the actual pose, root translation from target to target), each substep cancels the
people's internal forces (Coriolis, gyroscopic, weight) with applied ones. mj_step1 and mj_step2
instead of mj_step, because the forces to cancel are those of the present state: with mj_step the
motion is missed by 0.01 to 0.1 mm, and it is no faster.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from halfphysics.body.mjcf_person import Addresses

Array = NDArray[np.float64]


class Watch(Protocol):
    """An observer that is told of every substep."""

    def before(self, substep: int) -> None: ...
    def after(self, substep: int) -> None: ...


class VelocityDrive:
    """People in MuJoCo, driven by velocities.

    Args:
        model: A `mujoco.MjModel` in which people come first, all else after them.
        data: Its `mujoco.MjData`.
        people: Where the people are in it.
        substeps: MuJoCo steps per frame.
        dt: Length of a frame [s].
    """

    def __init__(
        self, model: Any, data: Any, people: Sequence[Addresses], substeps: int, dt: float
    ) -> None:
        import mujoco

        self._mujoco, self._model, self._data = mujoco, model, data
        self._substeps, self._dt = substeps, dt
        self._velocity = np.zeros(model.nv)
        self._roots = [(at.root_position, at.root_velocity) for at in people]
        ends = [int(at.dof.max()) + 3 for at in people]
        self._own = slice(0, max(ends, default=0))

    def frame(self, before: Array, target: Array, watch: Watch | None = None) -> Array:
        """One frame from the target before (nq,) towards a target (nq,); coordinates (nq,).

        Of targets only what is the people's is looked at. What comes back is the engine's own.
        """
        mj_step1, mj_step2 = self._mujoco.mj_step1, self._mujoco.mj_step2
        model, data, velocity, dt = self._model, self._data, self._velocity, self._dt
        self._mujoco.mj_differentiatePos(model, velocity, dt, data.qpos, target)
        for root, dof in self._roots:
            velocity[dof : dof + 3] = (target[root : root + 3] - before[root : root + 3]) / dt
        own = self._own
        data.qvel[own] = velocity[own]
        applied, internal = data.qfrc_applied[own], data.qfrc_bias[own]
        for k in range(self._substeps):
            if watch is not None:
                watch.before(k)
            mj_step1(model, data)
            applied[:] = internal
            mj_step2(model, data)
            if watch is not None:
                watch.after(k)
        return np.asarray(data.qpos)
