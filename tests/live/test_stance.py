"""How a person stands whom nobody moves."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.live.stance import RELAXING, stance
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.moment import standing_still


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


def lowest(body, pose):
    return body.vertices(standing_still(pose), frames=[0])[0, :, 2].min()


@pytest.mark.parametrize("height", [None, 0.3])
def test_soles_are_on_what_is_there(body, height):
    scene = hp.Scene()
    if height is not None:
        scene.add_static("step", hp.Box((1, 1, height)), position=(2.0, 1.0, 0.5 * height))
    pose = stance(body, scene, x=2.0, y=1.0)
    assert lowest(body, pose) == pytest.approx(height or 0.0, abs=1e-6)
    joints = body.joints(pose)
    np.testing.assert_allclose(joints[0, :2], (2.0, 1.0), atol=1e-9)


def test_arms_hang(body):
    joints = body.joints(stance(body, hp.Scene()))
    for side in ("left", "right"):
        wrist, shoulder = (joints[JOINT_INDEX[f"{side}_{j}"]] for j in ("wrist", "shoulder"))
        assert wrist[2] < shoulder[2] - 0.3


def test_legs_do_not_relax():
    assert not RELAXING[[JOINT_INDEX[j] for j in ("pelvis", "left_hip", "right_knee")]].any()
    assert RELAXING[JOINT_INDEX["left_wrist"]]
