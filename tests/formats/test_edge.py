"""Dances of EDGE: AIST++'s names, another axis, rate and unit, the place of the pelvis."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats import losses
from support.files.layouts import movement, quiet
from support.files.position_files import offsets, places, y_up
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    hostile_is_refused,
    refused,
    spoilt,
    usual,
)

ROUNDING = 2e-6  # metres, of single precision
BODY = hp.Body.default()
REST = np.asarray(BODY.rest_joints)
FRAMES = 12
PELVIS = 1.9  # metres; AIST++'s dancers are some metre above 0
#: The joints of SMPL among those of SMPL-X: its hands are where the middle fingers begin.
SMPL = [*range(22), 28, 43]


def truth(up: str = "z"):
    """Places of the pelvis and rotations without fingers, in the axes of the file."""
    translation, rotations = movement(FRAMES, up=up)
    rotations = np.array(rotations)
    rotations[:, 22:] = 0.0
    height = {"z": [0.0, 0.0, PELVIS], "y": [0.0, PELVIS, 0.0]}[up]
    return translation + height, rotations


def fields(up: str = "z"):
    pelvis, rotations = truth(up)
    poses = np.pad(rotations[:, :22], [(0, 0), (0, 2), (0, 0)])
    return {
        "smpl_poses": poses.reshape(FRAMES, 72).astype(np.float32),
        "smpl_trans": pelvis.astype(np.float32),
        "full_pose": places(rotations, pelvis, offsets(REST))[:, SMPL].astype(np.float32),
    }


def written(path, content):
    path.write_bytes(pickle.dumps(content))
    return path


def test_joints_are_those_of_the_file(tmp_path):
    content = fields()
    sequence = quiet(written(tmp_path / "test_mBR0.pkl", content))
    motion = sequence.motion
    assert np.abs(BODY.joints(motion)[:, SMPL] - content["full_pose"]).max() < ROUNDING
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smpl", "neutral")
    assert motion.origin.format == "edge"


def test_y_up_is_seen_by_how_the_dancer_stands(tmp_path):
    content = fields("y")
    path = written(tmp_path / "a.pkl", content)
    with (
        pytest.warns(hp.HalfPhysicsWarning, match="stands along y"),
        pytest.warns(hp.HalfPhysicsWarning, match="not in the file"),
    ):
        motion = hp.Motion.load(path)
    assert np.abs(y_up(BODY.joints(motion)[:, SMPL]) - content["full_pose"]).max() < ROUNDING


def test_what_is_invented_is_said(tmp_path):
    path = written(tmp_path / "a.pkl", fields())
    with pytest.warns(hp.HalfPhysicsWarning, match="hands, the rate .30 fps., the pelvis"):
        hp.Motion.load(path)


def test_on_the_floor(tmp_path):
    motion = quiet(written(tmp_path / "a.pkl", fields()), floor="lowest").motion
    assert abs(BODY.vertices(motion)[..., 2].min()) < ROUNDING


def test_written_as_it_came(tmp_path):
    content = fields()
    motion = quiet(written(tmp_path / "a.pkl", content)).motion
    motion.save(tmp_path / "b.pkl")
    again = pickle.loads((tmp_path / "b.pkl").read_bytes())
    assert again.keys() == content.keys()
    for key, value in content.items():
        assert np.abs(again[key] - value).max() < ROUNDING
    other = quiet(tmp_path / "b.pkl", frames=(2, 9)).motion
    assert len(other) == 7
    assert np.abs(BODY.joints(other) - BODY.joints(motion)[2:9]).max() < ROUNDING


def test_another_motion_is_written_with_z_up(tmp_path):
    motion = hp.scenarios.load("walk_into_wall").motion[:20]
    motion.save(tmp_path / "a.pkl", format="edge", body=BODY)
    other = quiet(tmp_path / "a.pkl").motion
    assert np.abs(BODY.joints(other)[:, :22] - BODY.joints(motion)[:, :22]).max() < ROUNDING


def test_the_pelvis_of_another_body_is_where_it_was(tmp_path):
    motion = hp.scenarios.load("walk_into_wall").motion[:20]
    tall = hp.Body.default(stature=1.9)
    motion.save(tmp_path / "a.pkl", format="edge", body=tall)
    content = pickle.loads((tmp_path / "a.pkl").read_bytes())
    assert np.abs(content["full_pose"] - tall.joints(motion)[:, SMPL]).max() < ROUNDING
    assert np.abs(content["smpl_trans"] - tall.joints(motion)[:, 0]).max() < ROUNDING
    other = quiet(tmp_path / "a.pkl").motion
    assert np.abs(BODY.joints(other)[:, 0] - tall.joints(motion)[:, 0]).max() < ROUNDING


WRONG = [
    *usual("smpl_poses")[1:],
    *usual("smpl_trans")[1:],
    ("joints too few", changed("full_pose", lambda a: a[:, :22]), "'full_pose'.*expected"),
    (
        "joints too short",
        changed("full_pose", lambda a: a[:-2]),
        "length.*full_pose.: 10",
    ),
    ("joints NaN", spoilt("full_pose", (3, 5, 0), np.nan), "'full_pose'.*NaN.*frame 3"),
    ("centimetres", changed("smpl_trans", lambda a: 100.0 * a), "'full_pose'.*beside smpl_trans"),
    ("translations", changed("smpl_trans", lambda a: a - REST[0]), "'full_pose'.*m beside"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "bad.pkl", content), message)


def test_without_joints_the_scaling_of_aist_is_asked_for(tmp_path):
    content = fields()
    del content["full_pose"]
    refused(written(tmp_path / "bad.pkl", content), "'smpl_scaling' is missing")


def test_hostile_and_broken_files(tmp_path):
    hostile_is_refused(tmp_path / "evil.pkl", fields(), "smpl_poses")
    broken_bytes_are_refused(written(tmp_path / "a.pkl", fields()))


def test_what_it_cannot_hold_is_said(tmp_path):
    translation, rotations = movement()
    motion = hp.Motion(translation, rotations, 60.0, betas=np.ones(10))
    assert losses(motion, tmp_path / "a.pkl", "edge") == [
        "the fingers",
        "jaw and eyes",
        "the model 'smplx' that the shape is of: readers take 'smpl'",
        "the shape (betas)",
        "the frame rate 60: readers take 30; say motion.resample(30)",
    ]
