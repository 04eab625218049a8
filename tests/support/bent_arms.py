"""A person with bent arms, and where its hands are."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot


def bent(frames=6, seed=0):
    """A person with bent arms."""
    rng = np.random.default_rng(seed)
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    for side, sign in (("left", 1.0), ("right", -1.0)):
        at = [hp.JOINT_NAMES.index(f"{side}_{name}") for name in ("shoulder", "elbow", "wrist")]
        rotations[:, at[0]] = [0.0, -sign * 0.6, -sign * 0.8]
        rotations[:, at[1]] = [0.0, -sign * 1.2, 0.0]
        rotations[:, at] += rng.normal(0.0, 0.1, (frames, 3, 3))
    return hp.Motion(np.zeros((frames, 3)), rotations, fps=30.0)


def where(motion, hand, body):
    position, quaternion = body.joint_frames(motion)
    return position[:, hand.wrist], rot.to_matrix(quaternion[:, hand.wrist])
