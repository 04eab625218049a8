"""The animation that the SMPL-X Blender add-on makes."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.errors import HalfPhysicsWarning, InputError
from halfphysics.formats import losses
from support.files.layouts import movement

#: Vertices [m] of the same numbers.
SAME = 1e-12
KEYS = {"trans", "gender", "betas", "poses", "mocap_frame_rate"}


def motion_at(fps: float = 60.0, frames: int = 13, **more) -> hp.Motion:
    more = {"betas": np.linspace(-1, 1, 16), "gender": "female"} | more
    return hp.Motion(*movement(frames), fps, **more)


def add_on(path, target: int = 30):
    """The fields that the add-on takes from a file, and its keyframes."""
    with np.load(path) as data:
        assert set(data) == KEYS
        rate = int(data["mocap_frame_rate"])
        assert rate >= target
        assert rate % target == 0
        step = int(rate / target)
        betas = [float(beta) for beta in data["betas"]]
        poses = [row.reshape(-1, 3) for row in data["poses"]][::step]
        return str(data["gender"]), betas, poses, data["trans"][::step]


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_the_add_on_plays_it_and_it_reads_back(tmp_path, fps):
    motion, body = motion_at(fps), hp.Body.default()
    motion.save(tmp_path / "a.npz", format="blender")
    gender, betas, poses, trans = add_on(tmp_path / "a.npz")
    step = int(fps / 30.0)
    assert gender == "female"
    assert np.array_equal(betas, motion.betas)
    assert np.array_equal(poses, motion.rotations[::step])
    assert np.array_equal(trans, motion.translation[::step])
    back = hp.Motion.load(tmp_path / "a.npz")
    assert (back.fps, back.model, back.origin.format) == (fps, "smplx", "amass-smplx")
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < SAME
    assert losses(motion, tmp_path / "a.npz", "blender") == []


@pytest.mark.parametrize(
    ("fps", "rate"), [(24.0, 30.0), (29.97, 30.0), (50.0, 60.0), (100.0, 120.0), (240.0, 120.0)]
)
def test_other_rates_are_resampled_and_said(tmp_path, fps, rate):
    motion, body = motion_at(60.0, 25).resample(fps), hp.Body.default()
    assert any("frame rate" in line for line in losses(motion, tmp_path / "a.npz", "blender"))
    with pytest.warns(HalfPhysicsWarning, match=f"resampled from {fps:g} to {rate:g}"):
        motion.save(tmp_path / "a.npz", format="blender")
    add_on(tmp_path / "a.npz", int(rate))
    back, asked = hp.Motion.load(tmp_path / "a.npz"), motion.resample(rate)
    assert back.fps == rate
    assert np.abs(body.vertices(back) - body.vertices(asked)).max() < SAME


def test_y_up_is_turned_about_the_pelvis(tmp_path):
    body = hp.Body.default()
    motion = motion_at().rebased(body, "y")
    assert np.array_equal(motion.axes, axes_of("y"))
    with pytest.raises(InputError, match="body="):
        motion.save(tmp_path / "a.npz", format="blender")
    motion.save(tmp_path / "a.npz", format="blender", body=body)
    back = hp.Motion.load(tmp_path / "a.npz")
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < SAME


def test_betas_of_another_model_are_left_out_and_said(tmp_path):
    motion = motion_at(model="smplh")
    assert "'smplh'" in losses(motion, tmp_path / "a.npz", "blender")[0]
    motion.save(tmp_path / "a.npz", format="blender")
    _, betas, _, _ = add_on(tmp_path / "a.npz")
    assert not np.any(betas)
    assert len(betas) == 10
    unknown = motion_at(betas=None)
    unknown.save(tmp_path / "b.npz", format="blender")
    assert not np.any(add_on(tmp_path / "b.npz")[1])
