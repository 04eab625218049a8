"""Somebody who stands still with bent knees, and has weight."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.metrics.airborne import centre_of_mass
from support.as_it_is import as_it_is

BODY = hp.Body.default()
WEIGHT = as_it_is(weight=True)
G = 9.81  # [m/s^2]


def standing(frames=90, fps=60.0, at=(0.0, 0.0), top=0.0, body=BODY):
    """Somebody who stands with bent knees at `at`, turned to -y, on the height `top` [m]."""
    rotations = np.zeros((frames, 55, 3))
    rotations[:, 0] = [np.pi / 2, 0.0, 0.0]
    for side in ("left", "right"):
        for joint, bend in (("hip", -0.5), ("knee", 1.0), ("ankle", -0.5)):
            rotations[:, hp.JOINT_NAMES.index(f"{side}_{joint}"), 0] = bend
    for side, turn in (("left", -1.2), ("right", 1.2)):  # arms down
        rotations[:, hp.JOINT_NAMES.index(f"{side}_shoulder"), 2] = turn
    motion = hp.Motion(np.zeros((frames, 3)), rotations, fps)
    low = body.vertices(motion[0])[:, 2].min()
    centre = centre_of_mass(motion, body)[0]
    offset = np.array([at[0] - centre[0], at[1] - centre[1], top + 0.0012 - low])
    return motion.with_frames(motion.translation + offset, rotations)


def mass(body=BODY):
    """Of a person [kg]."""
    return hp.simulate(standing(3, body=body), hp.Scene(), body=body).people[0].support.mass
