"""The peer: a plain MuJoCo loop that follows a motion, as in `baselines.engine.velocity`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.baselines.engine.scenery import add_scene
from halfphysics.baselines.engine.velocity import VelocityDrive
from halfphysics.body.mjcf_person import add_person, addresses

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene

Array = NDArray[np.float64]


class MujocoLoop:
    """One person in MuJoCo, driven by velocities.

    Args:
        body: The person; the same parts, masses and inertias as ours.
        fps: Frame rate.
        substeps: MuJoCo steps per frame.
        scene: Statics and objects, or None. The parts have geoms only with a scene: without
            contact they would only cost time.
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
            add_scene(spec, scene, hulls)
            spec.option.gravity = scene.gravity if scene.objects else [0.0, 0.0, 0.0]
        spec.option.timestep = 1.0 / fps / substeps
        self._mujoco = mujoco
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        places = addresses(self.model)
        self._drive = VelocityDrive(self.model, self.data, [places], substeps, 1.0 / fps)
        self._quats = places.quat[:, None] + np.arange(4)
        self._root = places.root_position
        self._pelvis = body.rest_joints[0]

    def coordinates(self, translation: Array, rotations: Array, axes: Array) -> Array:
        """Model coordinates (T, nq) of SMPL-X translations (T, 3) and rotations (T, 55, 3).

        Objects are at their initial positions.
        """
        qpos = np.tile(self.model.qpos0, (len(translation), 1))
        qpos[:, self._root : self._root + 3] = translation + axes @ self._pelvis
        qpos[:, self._quats] = rot.exp(rotations)
        return qpos

    def run(self, motion: Motion) -> Motion:
        """The simulated motion for the reference `motion`."""
        targets = self.coordinates(motion.translation, motion.rotations, motion.axes)
        return self.motion(self.play(targets), motion)

    def player(self, motion: Motion) -> Callable[[], Array]:
        """`play` of a motion with precomputed targets."""
        targets = self.coordinates(motion.translation, motion.rotations, motion.axes)
        return lambda: self.play(targets)

    def motion(self, qpos: Array, like: Motion) -> Motion:
        """Coordinates (T, nq) as a motion with all other values of `like`."""
        root = qpos[:, self._root : self._root + 3]
        return like.with_frames(
            root - like.axes @ self._pelvis, rot.log(np.take(qpos, self._quats, axis=1))
        )

    def play(self, targets: Array) -> Array:
        """Simulated coordinates (T, nq) for targets (T, nq).

        Coordinates of objects are read from the first row only: their initial positions.
        """
        out = np.empty_like(targets)
        self._reset(targets[0])
        out[0] = targets[0]
        for t in range(1, len(targets)):
            out[t] = self._drive.frame(targets[t - 1], targets[t])
        return out

    def reset(self, pose: Pose) -> None:
        """Start at a pose."""
        self._target = self._of(pose)
        self._reset(self._target)

    def step(self, pose: Pose) -> tuple[Array, Array]:
        """Simulate a frame towards a pose; returns translation (3,) and rotations (55, 3)."""
        target = self._of(pose)
        qpos = self._drive.frame(self._target, target)
        self._target = target
        translation = qpos[self._root : self._root + 3] - pose.axes @ self._pelvis
        return translation, rot.log(qpos[self._quats])

    def deepest(self, qpos: Array) -> float:
        """Deepest overlap of two geoms over poses (T, nq) [m], 0 without overlap.

        Computed by MuJoCo's collision detection of convex shapes, for poses of either side.
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
            self._drive.frame(targets[t - 1], targets[t])
            count += self.data.ncon
        return count / max(1, len(targets) - 1)

    def _of(self, pose: Pose) -> Array:
        result: Array = self.coordinates(pose.translation[None], pose.rotations[None], pose.axes)[0]
        return result

    def _reset(self, qpos: Array) -> None:
        self._mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = qpos
