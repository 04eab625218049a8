"""PROX: a person before a Kinect, put into the scan of the room."""

from __future__ import annotations

import json

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.files import recorded_sets as sets
from support.files.wrong_axes import walker
from support.files.wrong_files import refused

SOMEONE = sets.person(16, tuple(range(25)))
CAMERA = sets.Y_DOWN @ rot.rotvec_to_matrix([-0.3, 0.1, 0.05])
PLACE = np.array([1.3, -2.0, 1.6])


def written(tmp_path, hands=None, someone=SOMEONE, world=sets.Z_UP):
    recording = tmp_path / "PROXD" / "N3OpenArea_03403_01"
    hands = np.zeros((sets.FRAMES, 24)) if hands is None else hands
    for k, fields in enumerate(sets.frame_fields(someone, CAMERA, PLACE, hands)):
        fields |= {
            "camera_rotation": np.eye(3, dtype=np.float32)[None],
            "camera_translation": np.zeros((1, 3), dtype=np.float32),
            "pose_embedding": np.zeros((1, 32), dtype=np.float32),
        }
        fields["betas"] = fields["betas"] + 0.1 * (k - 6)
        sets.dump(
            recording / "results" / f"s001_frame_{k + 1:05d}__00.00.0{k // 30}" / "000.pkl", fields
        )
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = world.T @ CAMERA, world.T @ PLACE
    for name, text in (("cam2world", json.dumps(matrix.round(7).tolist())),):
        (tmp_path / name).mkdir(exist_ok=True)
        (tmp_path / name / "N3OpenArea.json").write_text(text)
    sets.mesh(tmp_path / "scenes" / "N3OpenArea.ply", (0.5, 0.1, 0.2))
    return recording


def test_in_the_room_upright(tmp_path):
    recording = written(tmp_path)
    for path in (recording, recording / "results"):
        sequence = sets.load(path)
        motion = sequence.motion
        assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "female")
        assert np.abs(motion.betas - (sets.BETAS - 0.05)).max() < sets.SINGLE  # the median
        assert sets.off(motion, SOMEONE) < sets.SINGLE
    room = sequence.scene.statics["N3OpenArea"]
    asked = sets.mesh(tmp_path / "own.ply", (0.5, 0.1, 0.2)).vertices
    away = np.linalg.norm(np.asarray(room.shape.vertices)[:, None] - asked[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < sets.SINGLE
    assert [clip.format for clip in hp.clips(tmp_path / "PROXD")] == ["prox"]


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_what_is_taken_or_missing_is_told(tmp_path):
    recording = written(tmp_path, np.full((sets.FRAMES, 24), 0.2))
    with pytest.warns(hp.HalfPhysicsWarning, match="12 principal components.*Name it with model="):
        hp.Motion.load(recording)
    with pytest.warns(hp.HalfPhysicsWarning, match="shape changes over the frames by up to 0.55"):
        hp.Motion.load(recording)
    (tmp_path / "cam2world" / "N3OpenArea.json").unlink()
    with pytest.warns(hp.HalfPhysicsWarning, match="frame of the camera.*cam2world/N3OpenArea"):
        motion = hp.Motion.load(recording)
    assert rot.to_matrix(rot.exp(motion.rotations[:, 0]))[:, 2, 1].mean() > 0.7
    refused(recording, "where its camera is in the scan is in cam2world/N3OpenArea.json")


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
@pytest.mark.parametrize(("up", "world"), [("y", sets.Y_UP), ("-y", sets.Y_DOWN)])
def test_a_scan_with_another_axis_up(tmp_path, monkeypatch, up, world):
    """The people in it say which, and it is turned with them."""
    motion = walker()
    someone = motion.translation, np.array(motion.rotations)
    monkeypatch.setattr(sets, "FRAMES", len(motion))
    recording = written(tmp_path, someone=someone, world=world)
    with pytest.warns(hp.HalfPhysicsWarning, match=f"read with {up} up: the person stands along"):
        sequence = hp.load_sequence(recording)
    assert sets.off(sequence.motion, someone) < sets.SINGLE
    room = sequence.scene.statics["N3OpenArea"]
    found = rot.rotate(room.quaternion, room.shape.vertices) + room.position
    asked = sets.mesh(tmp_path / "own.ply", (0.5, 0.1, 0.2)).vertices @ world.T
    away = np.linalg.norm(found[:, None] - asked[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < sets.SINGLE


def test_wrong_files(tmp_path):
    recording = written(tmp_path)
    table = tmp_path / "cam2world" / "N3OpenArea.json"
    for message, text in {
        "cannot be read": "nothing",
        r"no matrix \(4, 4\)": "[[1, 0], [0, 1]]",
        "expected a rigid transform": json.dumps(np.ones((4, 4)).tolist()),
    }.items():
        table.write_text(text)
        with pytest.raises(hp.HalfPhysicsError, match=message):
            sets.load(recording)
    written(tmp_path)
    (tmp_path / "scenes" / "N3OpenArea.ply").unlink()
    refused(recording, "the scan of 'N3OpenArea'.*scenes/N3OpenArea.ply")
    frame = sorted((recording / "results").iterdir())[4] / "000.pkl"
    whole = frame.read_bytes()
    for length in np.linspace(0, len(whole) - 1, 12).astype(int):
        frame.write_bytes(whole[:length])
        with pytest.raises(hp.HalfPhysicsError):
            hp.Motion.load(recording)
