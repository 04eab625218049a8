"""HY-Motion: AMASS's SMPL-H keys, y up, the root twice, no frame rate."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.errors import FileError
from halfphysics.motion.skeleton import SMPLH_JOINTS
from support.files.layouts import movement

#: Double precision through axis-angles.
ROUNDING = 1e-9
FRAMES = 12


def truth() -> tuple[np.ndarray, np.ndarray]:
    translation, r = movement(FRAMES, up="y")
    r[:, 22:25] = 0.0
    return translation, r


def fields() -> dict:
    translation, r = truth()
    return {
        "gender": np.array(["neutral"]),
        "Rh": r[:, 0],
        "trans": translation,
        "poses": r[:, list(SMPLH_JOINTS)].reshape(FRAMES, 156),
        "betas": np.zeros((1, 16)),
    }


@pytest.mark.parametrize("newer", [False, True])
def test_it_stands_upright_at_its_rate(tmp_path, newer):
    rate = {"mocap_framerate": np.array(30), "num_frames": np.array(FRAMES)} if newer else {}
    np.savez(tmp_path / "a.npz", **fields(), **rate)
    motion = hp.Motion.load(tmp_path / "a.npz")  # a warning would be an error
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smplh", "neutral")
    body = hp.Body.default()
    in_file = body.vertices(hp.Motion(*truth(), 30.0))
    assert np.abs(body.vertices(motion) - in_file @ axes_of("y").T).max() < ROUNDING
    moved = motion.with_frames(motion.translation, motion.rotations * 0.5)
    moved.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as again:
        assert set(fields()) <= set(again)
        assert np.array_equal(again["Rh"], again["poses"][:, :3])  # both follow
    part = hp.Motion.load(tmp_path / "a.npz", frames=(3, 9))
    assert np.array_equal(part.rotations, motion.rotations[3:9])


def test_a_root_that_is_only_in_rh_is_taken(tmp_path):
    content = fields()
    content["poses"][:, :3] = 0.0
    np.savez(tmp_path / "a.npz", **content)
    np.savez(tmp_path / "b.npz", **fields())
    found = [hp.Motion.load(tmp_path / f"{name}.npz", frames=(2, 9)) for name in "ab"]
    assert np.array_equal(found[0].rotations, found[1].rotations)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("Rh", np.zeros((5, 3)), "different length: found {'Rh': 5"),
        ("Rh", np.zeros((FRAMES, 4)), "'Rh': found shape"),
        ("trans", np.zeros((5, 3)), "'trans' has 5 frames"),
        ("poses", np.full((FRAMES, 156), np.inf), "'poses'.*infinite"),
        ("gender", np.array(["robot"]), "'gender': found 'robot'"),
    ],
)
def test_wrong_files(tmp_path, key, value, message):
    np.savez(tmp_path / "a.npz", **{**fields(), key: value})
    with pytest.raises(FileError, match=message):
        hp.Motion.load(tmp_path / "a.npz")
