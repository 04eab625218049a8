"""A glance at a motion agrees with the whole body's kinematics."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.formats.glance import glance, owners
from halfphysics.motion.skeleton import JOINT_INDEX
from support.files.layouts import movement

#: Both use the same double precision.
ROUNDING = 1e-12
BODY = hp.Body.default()


def test_it_sees_what_the_body_does():
    motion = hp.Motion(*movement(61), 60.0)
    seen = glance(motion.translation, motion.rotations, motion.fps, motion.axes)
    assert seen.duration == 1.0
    rows = np.unique(np.linspace(0, 58, 48).astype(int))  # and two frames on: a thirtieth
    assert len(seen.skin) == len(rows)
    points = BODY.vertices(motion)[:, ::24]
    assert np.abs(seen.skin - points[rows]).max() < ROUNDING
    speed = np.linalg.norm(points[rows + 2] - points[rows], axis=2) * 30.0
    assert np.abs(seen.speed - speed).max() < 1e3 * ROUNDING
    low = points[rows, :, 2].min(axis=1) - motion.translation[rows, 2]
    assert np.abs(seen.low - low).max() < ROUNDING
    joints = BODY.joints(motion)
    ankles = joints[:, [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]]
    way = (joints[:, JOINT_INDEX["head"]] - ankles.mean(axis=1))[rows]
    assert np.abs(np.linalg.norm(way, axis=1)[:, None] * seen.along - way).max() < 1e-9
    assert np.abs(seen.moved - (joints[rows + 2, 0] - joints[rows, 0])).max() < ROUNDING
    whole = seen.moved[:, None] + seen.feet
    assert np.abs(whole - (ankles[rows + 2] - ankles[rows])).max() < 10 * ROUNDING


def test_a_clip_of_two_frames_has_one_pair():
    translation, rotations = movement(2)
    seen = glance(translation, rotations, 120.0, np.eye(3))
    assert len(seen.along) == 1


def test_points_belong_to_the_joints_that_move_them():
    owner = owners()
    rest = BODY.rest_vertices[::24]
    toes = owner == JOINT_INDEX["left_foot"]
    assert toes.any()
    assert rest[toes, 1].max() < BODY.rest_joints[JOINT_INDEX["left_knee"], 1]
    assert (rest[toes, 0] > 0.0).all()
