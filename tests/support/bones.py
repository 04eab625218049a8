"""Bones of people: offsets of joints from their parents, and where they are in a motion."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS

#: Joints as models have them that find joints by regression: narrow, low hips, a short spine3.
#: No fingers. Rounded, invented.
ELSEWHERE = {
    "pelvis": (0.0, -0.35, 0.01),
    "hip": (0.06, -0.09, -0.02),
    "knee": (0.05, -0.38, 0.0),
    "ankle": (-0.03, -0.40, -0.03),
    "foot": (0.04, -0.06, 0.12),
    "spine1": (0.0, 0.11, -0.03),
    "spine2": (0.0, 0.135, 0.0),
    "spine3": (0.0, 0.055, 0.03),
    "neck": (0.0, 0.165, -0.03),
    "head": (0.0, 0.10, 0.03),
    "collar": (0.05, 0.085, -0.01),
    "shoulder": (0.11, 0.05, -0.02),
    "elbow": (0.25, -0.02, -0.02),
    "wrist": (0.25, 0.01, 0.0),
    "middle1": (0.10, -0.01, 0.0),
}


def own_bones(body: Body) -> np.ndarray:
    bones = body.rest_joints - body.rest_joints[np.maximum(PARENTS, 0)]
    bones[0] = body.rest_joints[0]
    return bones


def elsewhere(factor: float = 1.0) -> np.ndarray:
    bones = np.full((55, 3), np.nan)
    for joint, name in enumerate(JOINT_NAMES):
        place = ELSEWHERE.get(name.rpartition("_")[2])
        if place is not None:
            bones[joint] = factor * np.array(place)
            bones[joint, 0] *= -1.0 if name.startswith("right") else 1.0
    return bones


def world_joints(bones: np.ndarray, motion: hp.Motion) -> np.ndarray:
    """Forward kinematics of bones, written out, of unknown joints NaN."""
    places = np.full((len(motion), 55, 3), np.nan)
    for frame in range(len(motion)):
        turn = [rot.to_matrix(rot.exp(r)) for r in motion.rotations[frame]]
        places[frame, 0] = motion.axes @ bones[0] + motion.translation[frame]
        for joint in range(1, 55):
            turn[joint] = turn[PARENTS[joint]] @ turn[joint]
            places[frame, joint] = (
                places[frame, PARENTS[joint]] + turn[PARENTS[joint]] @ bones[joint]
            )
    return places
