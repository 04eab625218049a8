"""EMAGE and BEAT2: AMASS's keys, y up, told by what AMASS has not."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.errors import FileError, HalfPhysicsWarning
from halfphysics.formats import Source, identify
from support.files import model_files
from support.files.layouts import movement

#: Double precision through axis-angles.
ROUNDING = 1e-9
FRAMES = 12


def fields() -> dict:
    translation, r = movement(FRAMES, up="y")
    return {
        "betas": np.linspace(1.0, -1.0, 300),
        "poses": r.reshape(FRAMES, 165),
        "expressions": np.random.default_rng(0).normal(size=(FRAMES, 100)),
        "trans": translation,
        "model": np.array("smplx2020"),
        "gender": np.array("neutral"),
        "mocap_frame_rate": np.array(30),
    }


def test_it_stands_upright_at_its_rate(tmp_path):
    np.savez(tmp_path / "a.npz", **fields())
    motion = hp.Motion.load(tmp_path / "a.npz", hands="flat")  # a warning would be an error
    assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "neutral")
    assert np.array_equal(motion.betas, fields()["betas"])
    body = hp.Body.default()
    in_file = body.vertices(hp.Motion(*movement(FRAMES, up="y"), 30.0))
    assert np.abs(body.vertices(motion) - in_file @ axes_of("y").T).max() < ROUNDING
    motion.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as again:
        assert list(again) == list(fields())
        for key, value in fields().items():
            assert (
                np.abs(again[key] - value).max() < ROUNDING if value.ndim else again[key] == value
            )


@pytest.mark.parametrize("gone", ["model", "expressions", "mocap_frame_rate"])
def test_what_tells_it(tmp_path, gone):
    content = fields()
    del content[gone]
    np.savez(tmp_path / "a.npz", **content)
    assert identify(Source(tmp_path / "a.npz")).name == "emage"
    motion = hp.Motion.load(tmp_path / "a.npz", hands="flat")
    assert motion.fps == 30.0
    assert np.array_equal(motion.axes, axes_of("y"))


@pytest.mark.parametrize("bent", [True, False], ids=["fingers bent", "all fingers zero"])
def test_what_zero_fingers_mean_is_asked_and_taken_as_flat(tmp_path, bent):
    content = fields()
    if not bent:
        content["poses"][:, 75:] = 0.0
    np.savez(tmp_path / "a.npz", **content)
    with pytest.warns(
        HalfPhysicsWarning, match=r"whether zero fingers are .* taken as flat"
    ) as said:
        motion = hp.Motion.load(tmp_path / "a.npz")
    assert len(said) == 1
    assert np.array_equal(motion.rotations[:, 25:].reshape(FRAMES, 90), content["poses"][:, 75:])
    model = model_files.fields("smplx")
    np.savez(tmp_path / "SMPLX_NEUTRAL.npz", **model)
    relaxed = hp.Motion.load(tmp_path / "a.npz", hands="mean", model=tmp_path / "SMPLX_NEUTRAL.npz")
    mean = np.concatenate([model["hands_meanl"], model["hands_meanr"]])
    fingers = relaxed.rotations[:, 25:].reshape(FRAMES, 90)
    assert np.abs(fingers - content["poses"][:, 75:] - mean).max() < ROUNDING


def test_amass_is_still_amass(tmp_path):
    content = fields()
    del content["model"], content["expressions"]
    np.savez(tmp_path / "a.npz", **content)
    assert identify(Source(tmp_path / "a.npz")).name == "amass-smplx"


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("trans", None, "'trans' is missing"),
        ("trans", np.zeros((5, 3)), "'trans' has 5 frames"),
        ("poses", np.full((FRAMES, 165), np.nan), "'poses'.*NaN"),
        ("mocap_frame_rate", np.array(0.0), "'mocap_frame_rate': found 0"),
        ("gender", np.array("robot"), "'gender': found 'robot'"),
    ],
)
def test_wrong_files(tmp_path, key, value, message):
    content = fields()
    content[key] = value
    np.savez(tmp_path / "a.npz", **{k: v for k, v in content.items() if v is not None})
    with pytest.raises(FileError, match=message):
        hp.Motion.load(tmp_path / "a.npz")
