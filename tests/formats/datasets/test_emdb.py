"""EMDB: one person in the world, whose up axis is found."""

from __future__ import annotations

import warnings

import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.wrong_files import broken_bytes_are_refused, hostile_is_refused, refused, usual

SOMEONE = sets.person(4, tuple(range(22)))


def written(tmp_path, content=None):
    path = tmp_path / "P0" / "09_outdoor_walk" / "P0_09_outdoor_walk_data.pkl"
    return sets.dump(path, content or sets.emdb_fields(SOMEONE))


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
@pytest.mark.parametrize("axes", [sets.Y_UP, sets.Z_UP, sets.Y_DOWN], ids=["y", "z", "y down"])
def test_upright_whatever_axis_is_up(tmp_path, axes):
    path = written(tmp_path, sets.emdb_fields(SOMEONE, axes))
    with pytest.warns(hp.HalfPhysicsWarning, match="in 1 of 12 frames nobody is in view"):
        motion = hp.Motion.load(path)
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smpl", "female")
    assert motion.betas.tolist() == sets.BETAS.tolist()
    assert sets.off(motion, SOMEONE) < sets.DOUBLE


@pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")
def test_what_was_found_is_told(tmp_path):
    content = sets.emdb_fields(SOMEONE, sets.Z_UP)
    del content["good_frames_mask"]
    with pytest.warns(hp.HalfPhysicsWarning, match=r"stands along z: read with z up \(up="):
        hp.Motion.load(written(tmp_path, content))
    content["smpl"]["poses_root"] = content["smpl"]["poses_root"] * 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        hp.Motion.load(written(tmp_path, content))  # upright along y: nothing to say
    content["smpl"]["poses_root"] = content["smpl"]["poses_root"] + [0.0, 0.0, 1.57]
    with pytest.warns(hp.HalfPhysicsWarning, match=r"y up, as EMDB usually is; nobody stands"):
        hp.Motion.load(written(tmp_path, content))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [c[1:] for key in ("poses_root", "poses_body", "trans") for c in usual(key)],
)
def test_wrong_files(tmp_path, spoil, message):
    content = sets.emdb_fields(SOMEONE)
    spoil(content["smpl"])
    refused(written(tmp_path, content), message)


def test_a_wrong_mask_and_hostile_files(tmp_path):
    content = sets.emdb_fields(SOMEONE)
    short = {**content, "good_frames_mask": content["good_frames_mask"][:-1]}
    refused(written(tmp_path, short), "different length")
    hostile_is_refused(tmp_path / "b.pkl", content, "camera")
    broken_bytes_are_refused(written(tmp_path))
