"""Points of the default body's skin: each is where a nose, an ear, a heel or a toe is."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.formats.positions.landmarks import landmarks
from halfphysics.motion.skeleton import JOINT_INDEX

#: Both sides of the body are the same to this [m].
EVEN = 1e-3


def test_each_is_where_it_should_be():
    found, joints = landmarks(), np.asarray(hp.Body.default().rest_joints)
    ground = hp.Body.default().rest_vertices[:, 1].min()
    eye, head = joints[JOINT_INDEX["left_eye_smplhf"]], joints[JOINT_INDEX["head"]]
    assert abs(found["nose"][0]) < EVEN
    assert found["nose"][2] > eye[2]
    assert found["nose"][1] < eye[1]
    assert found["left_ear"][0] > eye[0]
    assert abs(found["left_ear"][1] - eye[1]) < 0.03
    assert found["left_ear"][2] < found["nose"][2] - 0.08
    assert found["left_ear"][1] > head[1]
    ankle, ball = (joints[JOINT_INDEX[f"left_{name}"]] for name in ("ankle", "foot"))
    heel, big, small = (found[f"left_{name}"] for name in ("heel", "big_toe", "small_toe"))
    assert heel[2] < ankle[2] < ball[2] < small[2] < big[2]
    assert big[0] < small[0]
    for point in (heel, big, small):
        assert point[1] - ground < 0.03


def test_sides_mirror_each_other():
    found = landmarks()
    for name in ("ear", "eye", "heel", "big_toe", "small_toe"):
        assert np.abs(found[f"left_{name}"] * [-1, 1, 1] - found[f"right_{name}"]).max() < EVEN
