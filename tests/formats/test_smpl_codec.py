""".smpl files: npz of float32 and int32, y-up, SMPL-X."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.files.layouts import movement
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    put,
    refused,
    spoilt,
    without,
)

#: Vertices [m] of poses in single precision.
SINGLE = 1e-6


def fields(frames: int = 12) -> dict:
    translation, r = movement(frames, up="y")
    single = {
        "bodyTranslation": translation,
        "bodyPose": r[:, [0, *BODY_JOINTS]],
        "headPose": r[:, [22, 23, 24]],
        "leftHandPose": r[:, list(LEFT_HAND_JOINTS)],
        "rightHandPose": r[:, list(RIGHT_HAND_JOINTS)],
        "shapeParameters": np.linspace(-1, 1, 10),
        "expressionParameters": np.ones((frames, 10)),
        "frameRate": np.array(60.0),
    }
    whole = {"codecVersion": 2, "smplVersion": 2, "gender": 1, "frameCount": frames}
    return {k: np.array(v, np.int32) for k, v in whole.items()} | {
        k: v.astype(np.float32) for k, v in single.items()
    }


def saved(path, content):
    with path.open("wb") as handle:  # savez would add a suffix
        np.savez_compressed(handle, **content)
    return path


def test_read_and_written(tmp_path):
    motion = hp.Motion.load(saved(tmp_path / "a.smpl", fields()))
    assert (motion.fps, motion.model, motion.gender) == (60.0, "smplx", "male")
    body = hp.Body.default()
    asked = body.vertices(hp.Motion(*movement(up="y"), 60.0)) @ axes_of("y").T
    assert np.abs(body.vertices(motion) - asked).max() < SINGLE
    motion.save(tmp_path / "b.smpl")
    again = np.load(tmp_path / "b.smpl")
    for key, value in fields().items():
        assert again[key].dtype == value.dtype, key
        assert np.abs(again[key] - value).max() < SINGLE, key
    # Files of other programs: by the suffix, with the body's pelvis.
    other = hp.Motion(*movement(), 30.0, betas=np.ones(10))
    other.save(tmp_path / "c.smpl", body=body)
    back = hp.Motion.load(tmp_path / "c.smpl")
    assert np.abs(body.vertices(back) - body.vertices(other)).max() < SINGLE
    assert np.array_equal(back.betas, other.betas)


@pytest.mark.parametrize("rows", [1, 11])
def test_expressions_are_of_each_frame_or_of_all(tmp_path, rows):
    content = {**fields(), "expressionParameters": np.ones((rows, 10), np.float32)}
    path = saved(tmp_path / "a.smpl", content)
    if rows == 1:
        motion = hp.Motion.load(path)
    else:
        with pytest.warns(hp.HalfPhysicsWarning, match="found 11 rows for 12 frames.*not kept"):
            motion = hp.Motion.load(path)
    motion.resample(30.0).save(tmp_path / "b.smpl")
    again = np.load(tmp_path / "b.smpl")
    kept = "expressionParameters" in again
    assert kept == (rows == 1)
    assert not kept or np.array_equal(again["expressionParameters"], np.ones((6, 10)))


WRONG = [
    ("no pose", without("bodyPose"), "holds a shape and no motion"),
    ("no translation", without("bodyTranslation"), "'bodyTranslation' is missing"),
    ("frame rate zero", put("frameRate", np.array(0.0)), "'frameRate'"),
    ("frame rate negative", put("frameRate", np.array(-30.0)), "'frameRate'"),
    ("frame rate NaN", put("frameRate", np.array(np.nan)), "'frameRate'"),
    ("frame rate of text", put("frameRate", np.array("60")), "'frameRate'"),
    ("SMPL-H", put("smplVersion", np.array(1)), "'smplVersion'.*SMPL-X"),
    ("gender 3", put("gender", np.array(3)), "'gender'.*0 neutral"),
    ("gender of text", put("gender", np.array("male")), "'gender'"),
    ("pose flat", changed("bodyPose", lambda a: a.reshape(12, 66)), "'bodyPose'"),
    ("24 joints", put("bodyPose", np.zeros((12, 24, 3))), "'bodyPose'"),
    ("matrices", put("bodyPose", np.zeros((12, 22, 3, 3))), "'bodyPose'"),
    ("pose NaN", spoilt("bodyPose", (3, 1, 0), np.nan), "'bodyPose'.*NaN.*frame 3"),
    ("hand of 16", put("leftHandPose", np.zeros((12, 16, 3))), "'leftHandPose'"),
    ("hand NaN", spoilt("rightHandPose", (2, 0, 0), np.inf), "'rightHandPose'"),
    ("head of 2", put("headPose", np.zeros((12, 2, 3))), "'headPose'"),
    ("other lengths", changed("leftHandPose", lambda a: a[:-1]), "different length"),
    ("translation 2-d", changed("bodyTranslation", lambda a: a[:, :2]), "'bodyTranslation'"),
    ("a jump", spoilt("bodyTranslation", (5, 0), 1e4), "m/s between frames"),
    ("shape per frame", put("shapeParameters", np.random.default_rng(0).normal(size=(12, 10))),
     "changes over the frames"),
    ("no fields", lambda f: [f.pop(k) for k in list(f) if k != "smplVersion"], "no motion"),
]  # fmt: skip


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(saved(tmp_path / "bad.smpl", content), message)


def test_broken_bytes(tmp_path):
    broken_bytes_are_refused(saved(tmp_path / "a.smpl", fields()))
