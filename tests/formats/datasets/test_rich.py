"""RICH: a folder for each frame, people in the frame of a camera, a scan around them."""

from __future__ import annotations

import json

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.files import recorded_sets as sets
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import refused

PEOPLE = [sets.person(seed, tuple(range(25))) for seed in (14, 15)]
HANDS = np.random.default_rng(2).normal(0, 0.1, (sets.FRAMES, 24))
#: A camera that is tilted, in the data set's world with y up, whose unit is not quite a metre.
CAMERA = sets.Y_DOWN @ rot.rotvec_to_matrix([0.4, 0.2, -0.1])
PLACE = np.array([0.3, -1.0, 1.4])
UNIT = 1.02


def written(tmp_path, gap=None):
    """Two people, the second from frame 2 on."""
    folder = tmp_path / "bodies" / "train" / "Pavallion_003_sitting"
    for index, (name, someone) in enumerate(zip(("003", "018"), PEOPLE, strict=True)):
        for k, fields in enumerate(sets.frame_fields(someone, CAMERA, PLACE, HANDS)):
            if k >= 2 * index and (gap is None or not gap[0] <= k < gap[1]):
                sets.dump(folder / f"{k + 30:05d}" / f"{name}.pkl", fields)
    turn = sets.Y_UP.T @ CAMERA
    table = {"R": turn.T.tolist(), "c": UNIT, "t": (UNIT * sets.Y_UP.T @ PLACE).tolist()}
    path = tmp_path / "multicam2world" / "Pavallion_multicam2world.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(table))
    sets.mesh(tmp_path / "scan_calibration" / "Pavallion" / "scan_camcoord.ply", (0.1, 0.2, 0.3))
    return folder


def test_both_people_and_the_scan_upright(tmp_path):
    sequence = sets.load(written(tmp_path))
    for motion, someone, gender in zip(sequence.motions, PEOPLE, ("male", "female"), strict=True):
        assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", gender)
        assert np.abs(motion.betas - sets.BETAS).max() < sets.SINGLE
        assert sets.off(motion, tuple(a[2:] for a in someone)) < sets.SINGLE
    scan = sequence.scene.statics["Pavallion"]
    path = tmp_path / "own.ply"
    asked = sets.placed(sets.mesh(path, (0.1, 0.2, 0.3)).vertices, PLACE, CAMERA)
    found = rot.rotate(scan.quaternion, scan.shape.vertices) + scan.position
    away = np.linalg.norm(found[:, None] - asked[None], axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < sets.SINGLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_one_person_with_hands_by_the_model_and_gaps(tmp_path):
    content = model_fields("smplx")
    model = write_npz(tmp_path / "SMPLX_MALE.npz", content)
    full = PEOPLE[0][1].copy()
    for joints, side, part in ((sets.LEFT, "l", HANDS[:, :12]), (sets.RIGHT, "r", HANDS[:, 12:])):
        bent = content[f"hands_mean{side}"] + part @ content[f"hands_components{side}"][:12]
        full[:, joints] = bent.reshape(-1, 15, 3)
    folder = written(tmp_path, gap=(4, 6))
    motion = hp.Motion.load(folder, clip="003", model=model)
    kept = [k for k in range(sets.FRAMES) if not 4 <= k < 6]
    assert len(motion) == sets.FRAMES
    seen = hp.Motion(motion.translation[kept], motion.rotations[kept], 30.0, axes=motion.axes)
    assert sets.off(seen, (PEOPLE[0][0][kept], full[kept])) < sets.SINGLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_what_is_missing_is_told(tmp_path):
    folder = written(tmp_path)
    (tmp_path / "multicam2world" / "Pavallion_multicam2world.json").unlink()
    with pytest.warns(hp.HalfPhysicsWarning, match="frame of the first camera.*assets="):
        motion = hp.Motion.load(folder, clip="003")
    up = rot.to_matrix(rot.exp(motion.rotations[:, 0]))[:, 2, 1]
    assert up.mean() > 0.7  # as upright as the camera
    (tmp_path / "scan_calibration" / "Pavallion" / "scan_camcoord.ply").unlink()
    refused(folder, "the scan of 'Pavallion'.*scan_camcoord.ply")


def test_wrong_files(tmp_path):
    folder = written(tmp_path)
    table = tmp_path / "multicam2world" / "Pavallion_multicam2world.json"
    wrong = {
        "cannot be read": "{",
        r"expected R \(3, 3\), c and t": "[]",
        "found no rotation": json.dumps({"R": np.ones((3, 3)).tolist(), "t": [0, 0, 0]}),
        "'c': found 0": json.dumps({"R": np.eye(3).tolist(), "c": 0, "t": [0, 0, 0]}),
    }
    for message, text in wrong.items():
        table.write_text(text)
        with pytest.raises(hp.HalfPhysicsError, match=message):
            sets.load(folder)
    written(tmp_path)
    frame = folder / "00035" / "003.pkl"
    good = sets.stored(frame)
    for message, content in {
        "'transl' is missing": {k: v for k, v in good.items() if k != "transl"},
        "found 60 numbers, expected 63": {**good, "body_pose": good["body_pose"][:, :60]},
        "expected a dict": [1],
        "NaN": {**good, "transl": good["transl"] * np.nan},
    }.items():
        sets.dump(frame, content)
        with pytest.raises(hp.HalfPhysicsError, match=message):
            sets.load(folder)
    frame.write_bytes(b"cos\nsystem\n(S'true'\ntR.")
    with pytest.raises(hp.HalfPhysicsError, match="unsafe or unknown content"):
        sets.load(folder)
