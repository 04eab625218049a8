"""Bones are those of the skeleton, and hinges flex as people's do."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.formats.limb_bones import BONES, HINGES
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, PARENTS

REST = np.asarray(hp.Body.default().rest_joints)


def test_bones_end_at_the_only_child_among_the_first_22():
    only = {}
    for joint in range(22):
        below = [c for c in range(22) if PARENTS[c] == joint]
        if len(below) == 1 and not JOINT_NAMES[joint].startswith("spine"):
            only[joint] = below[0]
    assert only == BONES


def test_knees_bend_backwards_and_elbows_forwards():
    assert [JOINT_NAMES[hinge.joint] for hinge in HINGES] == [
        "left_knee",
        "left_elbow",
        "right_knee",
        "right_elbow",
    ]
    for hinge in HINGES:
        assert PARENTS[hinge.joint] == hinge.upper
        end = BONES[hinge.joint]
        turned = Rotation.from_rotvec(0.5 * np.pi * hinge.axis).apply(REST[end] - REST[hinge.joint])
        ahead = turned[2] / np.linalg.norm(turned)
        assert (ahead < -0.95) if "knee" in JOINT_NAMES[hinge.joint] else (ahead > 0.95)


def test_neck_and_head():
    assert BONES[JOINT_INDEX["neck"]] == JOINT_INDEX["head"]
