"""AIST++ files: y-up, scaled, no fingers."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.motion.skeleton import SMPL_JOINTS
from support.files.layouts import movement
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    hostile_is_refused,
    put,
    refused,
    spoilt,
    usual,
    without,
)

SCALING = 93.7
ROUNDING = 1e-12  # metres, of numbers of size 1


def fields(frames: int = 12) -> dict:
    translation, rotations = movement(frames, up="y")
    poses = np.zeros((frames, 24, 3))
    poses[:, :22] = rotations[:, list(SMPL_JOINTS)]
    poses[:, 22:] = 0.1
    return {
        "smpl_loss": 0.5,
        "smpl_poses": poses.reshape(frames, 72),
        "smpl_scaling": np.array([SCALING]),
        "smpl_trans": translation * SCALING,
    }


def written(path, content):
    path.write_bytes(pickle.dumps(content))
    return path


def test_metres_axes_and_joints(tmp_path):
    path = written(tmp_path / "gBR_sBM_cAll_d04_mBR0_ch01.pkl", fields())
    motion = hp.Motion.load(path)
    assert (motion.fps, motion.model, motion.gender, motion.betas) == (
        60.0,
        "smpl",
        "male",
        None,
    )
    # The body as the file has it, turned as a whole: on the vertices.
    body = hp.Body.default()
    translation, rotations = movement(up="y")
    rotations[:, 22:] = 0.0
    asked = body.vertices(hp.Motion(translation, rotations, 60.0))
    turned = asked @ axes_of("y").T
    assert np.abs(body.vertices(motion) - turned).max() < ROUNDING


def test_written_as_it_came(tmp_path):
    path = written(tmp_path / "a.pkl", fields())
    motion = hp.Motion.load(path)
    motion.save(tmp_path / "b.pkl")
    again = pickle.loads((tmp_path / "b.pkl").read_bytes())
    for key, value in fields().items():
        assert np.abs(np.asarray(again[key]) - value).max() < ROUNDING * SCALING
    # In z-up files the pelvis at rest is added along another axis: the body says where it is.
    with pytest.raises(hp.HalfPhysicsError, match="body="):
        motion.save(tmp_path / "c.npz")
    body = hp.Body.default()
    motion.save(tmp_path / "c.npz", body=body)
    other = hp.Motion.load(tmp_path / "c.npz")
    assert np.abs(body.vertices(other) - body.vertices(motion)).max() < ROUNDING


WRONG = [
    *usual("smpl_poses"),
    *usual("smpl_trans"),
    ("no scaling", without("smpl_scaling"), "'smpl_scaling' is missing"),
    ("scaling zero", put("smpl_scaling", np.zeros(1)), "'smpl_scaling'.*expected a number"),
    ("scaling negative", put("smpl_scaling", np.array([-94.0])), "'smpl_scaling'"),
    ("two scalings", put("smpl_scaling", np.ones(2)), "'smpl_scaling'.*found"),
    ("one frame", lambda f: f.update({k: f[k][:1] for k in ("smpl_poses", "smpl_trans")}), "1 fr"),
    ("a jump", spoilt("smpl_trans", (5, 0), 1e5), "m/s between frames"),
    ("matrices", changed("smpl_poses", lambda a: np.zeros((12, 24, 3, 3))), "'smpl_poses'"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "bad.pkl", content), message)


def test_hostile_and_broken_files(tmp_path):
    hostile_is_refused(tmp_path / "evil.pkl", fields(), "smpl_loss")
    broken_bytes_are_refused(written(tmp_path / "a.pkl", fields()))


def test_what_it_cannot_hold_is_said(tmp_path):
    from halfphysics.formats import losses

    translation, rotations = movement()
    motion = hp.Motion(translation, rotations, 30.0, betas=np.ones(10))
    said = losses(motion, tmp_path / "a.pkl", "aist")
    assert said == [
        "the fingers",
        "jaw and eyes",
        "the shape (betas)",
        "the gender 'neutral': readers take male",
        "the frame rate 30: readers take 60; say motion.resample(60)",
    ]
