"""A motion played in plain MuJoCo by mocap bodies: set where they are to be, through obstacles too.

The pose is interpolated and set before every step: the root along straight lines, joints by SLERP,
at the end of the step, so that objects answer to where the person will be and not to where they
were. (Set once a frame, the same bodies jump eight steps' way at once.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.body import skinning

if TYPE_CHECKING:
    from halfphysics.baselines.engine.velocity import Watch
    from halfphysics.motion.motion import Motion
    from halfphysics.simulation.coordinates import Person

Array = NDArray[np.float64]


class MocapDrive:
    """People in MuJoCo as mocap bodies.

    Args:
        model: A `mujoco.MjModel`.
        data: Its `mujoco.MjData`.
        mocap: Mocap ids of the people's parts (people, 55).
        people: Their names and bodies.
        motions: What they do.
        substeps: MuJoCo steps per frame.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        mocap: NDArray[np.int64],
        people: Sequence[Person],
        motions: Sequence[Motion],
        substeps: int,
    ) -> None:
        import mujoco

        self._mujoco, self._model, self._data = mujoco, model, data
        self._mocap, self._people, self._motions = mocap, people, motions
        self._substeps = substeps

    def frame(self, t: int, watch: Watch) -> None:
        """The way to frame t."""
        poses = [
            frames(person, motion, t, self._substeps)
            for person, motion in zip(self._people, self._motions, strict=True)
        ]
        for k in range(self._substeps):
            for ids, (positions, quaternions) in zip(self._mocap, poses, strict=True):
                self._data.mocap_pos[ids] = positions[k]
                self._data.mocap_quat[ids] = quaternions[k]
            watch.before(k)
            self._mujoco.mj_step(self._model, self._data)
            watch.after(k)


def between(motion: Motion, t: int, substeps: int) -> tuple[Array, Array]:
    """Translation (N, 3) and rotations (N, 55, 3) at the ends of N equal steps to frame t."""
    share = np.arange(1, substeps + 1)[:, None] / substeps
    was, now = motion.translation[t - 1], motion.translation[t]
    turns = rot.exp(motion.rotations[t - 1 : t + 1])
    rotations = rot.log(rot.slerp(turns[0], turns[1], np.broadcast_to(share, (substeps, 55))))
    # At the frame itself nothing is rounded.
    return np.vstack([was + share[:-1] * (now - was), now]), np.concatenate(
        [rotations[:-1], motion.rotations[t : t + 1]]
    )


def frames(person: Person, motion: Motion, t: int, substeps: int) -> tuple[Array, Array]:
    """World frames of the joints, (N, 55, 3) [m] and (N, 55, 4), at the ends of N equal steps."""
    translation, rotations = between(motion, t, substeps)
    rest = person.body.rest_joints
    return skinning.kinematics(rotations, translation + motion.axes @ rest[0], rest)
