"""Somebody who squats on z = 0, facing -y, arms out."""

import numpy as np

import halfphysics as hp


def squatting(body, hip, knee, ankle, frames=60, fps=30.0):
    """A still motion with hips, knees and ankles bent so far [rad], the soles at z = 0."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side in ("left", "right"):
        for joint, bend in (("hip", -hip), ("knee", knee), ("ankle", -ankle)):
            rotations[:, hp.JOINT_NAMES.index(f"{side}_{joint}"), 0] = bend
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = body.vertices(motion[0])[:, 2].min()
    return motion.with_frames(motion.translation - [0.0, 0.0, low], rotations)
