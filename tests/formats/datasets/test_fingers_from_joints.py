"""Fingers from where their joints and tips are."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.formats.datasets.fingers_from_joints import fingers_from_joints
from halfphysics.motion.skeleton import JOINT_INDEX
from support.carries.files.core4d import tips_of

FRAMES, EXACT = 7, 1e-9
#: Fingers whose bones bend about this axis have no turn about them.
BEND = np.array([0.0, 0.0, 1.0])


def moved(size):
    """A motion of all fingers, and the 127 positions of it."""
    body = hp.Body.default()
    rotations = np.zeros((FRAMES, 55, 3))
    rotations[:, 0] = [0.4, -0.2, 0.9]
    rotations[:, 20:22] = [0.2, 0.3, -0.4]
    phase = np.linspace(0.0, 1.0, FRAMES)[:, None]
    for joint in range(25, 55):
        end = body.rest_joints[joint + 1] if joint % 3 != 0 else None
        if end is None:
            side = "left" if joint < 40 else "right"
            number = (joint - (25 if side == "left" else 40)) // 3
            finger = ("index", "middle", "pinky", "ring", "thumb")[number]
            order = ("thumb", "index", "middle", "ring", "pinky").index(finger)
            end = body.rest_vertices[tips_of(body)[66 + order + (0 if side == "left" else 5)]]
        bone = end - body.rest_joints[joint]
        across = np.cross(bone, BEND)
        rotations[:, joint] = size * phase * across / np.linalg.norm(across)
    motion = hp.Motion(np.zeros((FRAMES, 3)), rotations, 30.0)
    places = np.zeros((FRAMES, 127, 3))
    places[:, :55], turns = body.joint_frames(motion)
    tips = tips_of(body)
    places[:, list(tips)] = body.vertices(motion, indices=list(tips.values()))
    return motion, places, turns


@pytest.mark.parametrize("side", ["left", "right"])
def test_bent_fingers(side):
    motion, places, turns = moved(0.9)
    found = fingers_from_joints(side, places, turns[:, JOINT_INDEX[f"{side}_wrist"]])
    first = 25 if side == "left" else 40
    joints = [k for k in range(15) if (first + k) % 3 != 0]
    want = motion.rotations[:, first : first + 15]
    assert np.abs(found[:, joints] - want[:, joints]).max() < EXACT
    # A tip is of the skin, which its weights hold back a little.
    assert np.abs(found - want).max() < 0.1


def test_without_tips_the_last_joint_turns_as_the_one_before():
    _, places, turns = moved(0.9)
    found = fingers_from_joints("left", places[:, :55], turns[:, 20])
    assert np.abs(found[:, 2::3] - found[:, 1::3]).max() < EXACT
    assert np.abs(found[:, 1::3]).max() > 0.5


def test_flat_hands_have_none():
    _, places, turns = moved(0.0)
    places[:, 66:76] += 0.003
    assert not fingers_from_joints("left", places, turns[:, 20]).any()


def test_half_a_turn_is_one():
    """Straight back, about any axis across the bone."""
    body = hp.Body.default()
    places = np.zeros((1, 55, 3))
    places[0] = body.rest_joints
    places[0, 26] = 2.0 * places[0, 25] - body.rest_joints[26]
    found = fingers_from_joints("left", places, np.array([[1.0, 0.0, 0.0, 0.0]]))
    assert np.linalg.norm(found[0, 0]) == pytest.approx(np.pi)
    bone = body.rest_joints[26] - body.rest_joints[25]
    assert np.abs(rot.rotate(rot.exp(found[0, 0]), bone) + bone).max() < 1e-6
