"""The peer: a plain MuJoCo loop that follows a motion, as one would write it by hand.

Each frame sets the velocities that lead to the target (Algorithm 1: joints and root rotation
from the actual pose, root translation from target to target), each substep cancels the person's
internal forces (Coriolis, gyroscopic, weight) with applied ones. mj_step1 and mj_step2
instead of mj_step, because the forces to cancel are those of the present state: with mj_step the
motion is missed by 0.01 to 0.1 mm, and it is no faster.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics import rotations as rot
from halfphysics.bench.mujoco_scene import add_scene
from halfphysics.person_model import add_person, addresses

if TYPE_CHECKING:
    from halfphysics.body import Body
    from halfphysics.motion import Motion
    from halfphysics.pose import Pose
    from halfphysics.scene import Scene

Array = NDArray[np.float64]


class MujocoLoop:
    """One person in MuJoCo, driven by velocities.

    Args:
        body: The person; the same parts, masses and inertias as ours.
        fps: Frame rate.
        substeps: MuJoCo steps per frame.
        scene: What stands in the way and what can be pushed, or None. The parts get their geoms
            only then: with nothing to touch they would cost time.
        hulls: Name of a static mesh -> points (n, 3) of its convex pieces [m], in its own frame.
    """

    def __init__(
        self,
        body: Body,
        fps: float,
        substeps: int,
        scene: Scene | None = None,
        hulls: Mapping[str, Sequence[Array]] | None = None,
    ) -> None:
        import mujoco

        spec = mujoco.MjSpec()
        add_person(spec, body.variant, geoms=scene is not None)
        spec.option.gravity = [0.0, 0.0, 0.0]
        if scene is not None:
            add_scene(spec, scene, hulls or {})
            spec.option.gravity = scene.gravity if scene.objects else [0.0, 0.0, 0.0]
        spec.option.timestep = 1.0 / fps / substeps
        self._mujoco = mujoco
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.substeps = substeps
        self._dt = 1.0 / fps
        self._velocity = np.zeros(self.model.nv)
        places = addresses(self.model)
        # The person was added first: the rest of the velocities are objects'.
        self._own = slice(0, self.model.nv - 6 * (len(scene.objects) if scene else 0))
        self._quats = places.quat[:, None] + np.arange(4)
        self._root, self._root_dof = places.root_position, places.root_velocity
        self._pelvis = body.rest_joints[0]

    def coordinates(self, translation: Array, rotations: Array, axes: Array) -> Array:
        """Model coordinates (T, nq) of SMPL-X translations (T, 3) and rotations (T, 55, 3).

        Objects are where they start.
        """
        qpos = np.tile(self.model.qpos0, (len(translation), 1))
        qpos[:, self._root : self._root + 3] = translation + axes @ self._pelvis
        qpos[:, self._quats] = rot.exp(rotations)
        return qpos

    def run(self, motion: Motion) -> Motion:
        """The motion that comes of following `motion`."""
        targets = self.coordinates(motion.translation, motion.rotations, motion.axes)
        return self.motion(self.play(targets), motion)

    def player(self, motion: Motion) -> Callable[[], Array]:
        """`play` of a motion, targets ready."""
        targets = self.coordinates(motion.translation, motion.rotations, motion.axes)
        return lambda: self.play(targets)

    def motion(self, qpos: Array, like: Motion) -> Motion:
        """Coordinates (T, nq) as a motion that is `like` another in all else."""
        root = qpos[:, self._root : self._root + 3]
        return like.with_frames(
            root - like.axes @ self._pelvis, rot.log(np.take(qpos, self._quats, axis=1))
        )

    def play(self, targets: Array) -> Array:
        """Coordinates (T, nq) that come of following targets (T, nq).

        What is not the person's is read in the first row only: where objects start.
        """
        out = np.empty_like(targets)
        self._reset(targets[0])
        out[0] = targets[0]
        for t in range(1, len(targets)):
            out[t] = self._frame(targets[t - 1], targets[t])
        return out

    def reset(self, pose: Pose) -> None:
        """Start at a pose."""
        self._target = self._of(pose)
        self._reset(self._target)

    def step(self, pose: Pose) -> tuple[Array, Array]:
        """One frame towards a pose; the translation (3,) and rotations (55, 3) that come of it."""
        target = self._of(pose)
        qpos = self._frame(self._target, target)
        self._target = target
        translation = qpos[self._root : self._root + 3] - pose.axes @ self._pelvis
        return translation, rot.log(qpos[self._quats])

    def deepest(self, qpos: Array) -> float:
        """Deepest overlap of two things over poses (T, nq) [m], 0 where nothing overlaps.

        By MuJoCo's own collision of convex shapes, whoever the poses come from.
        """
        model, data = self.model, self._mujoco.MjData(self.model)
        worst = 0.0
        for row in qpos:
            data.qpos[:] = row
            self._mujoco.mj_fwdPosition(model, data)
            if data.ncon:
                worst = max(worst, -float(data.contact.dist.min()))
        return worst

    def contacts(self, targets: Array) -> float:
        """Mean number of contact points at the ends of frames while following targets (T, nq)."""
        self._reset(targets[0])
        count = 0
        for t in range(1, len(targets)):
            self._frame(targets[t - 1], targets[t])
            count += self.data.ncon
        return count / max(1, len(targets) - 1)

    def _of(self, pose: Pose) -> Array:
        return self.coordinates(pose.translation[None], pose.rotations[None], pose.axes)[0]

    def _reset(self, qpos: Array) -> None:
        self._mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = qpos

    def _frame(self, before: Array, target: Array) -> Array:
        mj_step1, mj_step2 = self._mujoco.mj_step1, self._mujoco.mj_step2
        model, data, velocity, dt = self.model, self.data, self._velocity, self._dt
        self._mujoco.mj_differentiatePos(model, velocity, dt, data.qpos, target)
        root, dof = self._root, self._root_dof
        velocity[dof : dof + 3] = (target[root : root + 3] - before[root : root + 3]) / dt
        own = self._own
        data.qvel[own] = velocity[own]
        applied, internal = data.qfrc_applied[own], data.qfrc_bias[own]
        for _ in range(self.substeps):
            mj_step1(model, data)
            applied[:] = internal
            mj_step2(model, data)
        return data.qpos
