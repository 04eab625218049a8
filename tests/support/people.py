"""Small motions and runs that the physics tests share."""

from __future__ import annotations

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.motion.motion import Motion
from halfphysics.simulation.simulator import Simulator

#: The T-pose of `along_x` has its pelvis here and its soles this high [m].
MIDDLE, SOLES = -0.4, -0.925
#: Root rotation of a person who stands upright in the z-up world and faces +x.
FACING_X = rot.log(rot.multiply(rot.exp([0.0, 0.0, np.pi / 2]), rot.exp([np.pi / 2, 0.0, 0.0])))


def t_pose(translation, fps=30.0):
    """A motion in T-pose along a path (T, 3), facing +x."""
    rotations = np.zeros((len(translation), 55, 3))
    rotations[:, 0] = FACING_X
    return Motion(np.asarray(translation, dtype=float), rotations, fps)


def along_x(speed, frames, start, turn=None, fps=30.0, z=0.0):
    """T-pose walking along x at `speed` [m/s]; from frame `turn` on backwards."""
    way = np.ones(frames - 1)
    if turn is not None:
        way[turn:] = -1.0
    path = np.zeros((frames, 3))
    path[:, 0] = start + np.concatenate([[0.0], np.cumsum(way)]) * speed / fps
    path[:, 2] = z
    return t_pose(path, fps)


def violent(frames=90, fps=30.0, seed=0):
    """Joints at up to 15 m/s and more, the root through several revolutions, half turns between
    frames, and axis-angle vectors that jump by 2 pi (their quaternions flip sign)."""
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / fps
    rotations = rng.normal(size=(1, 55, 3)) * np.sin(
        1.0 + 2 * np.pi * rng.uniform(1.0, 4.0, size=(1, 55, 1)) * t
    )
    angle = np.linspace(0.0, 7 * np.pi, frames)
    rotations[:, 0] = rot.log(
        rot.multiply(rot.exp(np.outer(angle, [0.0, 0.0, 1.0])), rot.exp(FACING_X))
    )
    rotations[frames // 2 :, 18, 0] += np.pi  # a half turn from one frame to the next
    size = np.linalg.norm(rotations[::3, 16], axis=1, keepdims=True)
    rotations[::3, 16] *= 1.0 + 2 * np.pi / size  # the same rotation, another quaternion sign
    path = np.cumsum(rng.normal(size=(frames, 3)), axis=0) * 0.1
    return Motion(path, rotations, fps)


def follow(motion, scene, body, settings):
    """The frames of a run and the corrected motion."""
    simulator = Simulator(scene, body=body, settings=settings, fps=motion.fps)
    frames = [simulator.reset(motion[0])]
    frames += [simulator.step(motion[t]) for t in range(1, len(motion))]
    corrected = motion.with_frames(
        np.array([f.pose.translation for f in frames]), np.array([f.pose.rotations for f in frames])
    )
    return frames, corrected, simulator
