"""GEM-X: SOMA poses of a video; the same clip as Kimodo's npz is the truth, GVHMR's for SMPL-X."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import HalfPhysicsWarning
from halfphysics.formats import Source, identify
from halfphysics.formats.skeletons.soma import SOMA
from support.files import video_files
from support.files.dumps import torch_dict
from support.files.layouts import movement, quiet
from support.files.soma_files import Clip, gemx, gemx_data, kimodo, of_default_body
from support.files.video_files import person
from support.files.wrong_files import broken_bytes_are_refused, changed, refused, spoilt, without

SINGLE = 1e-5  # metres and radians, of single precision
FRAMES = 16


def clip() -> Clip:
    """SOMA's mean person with all joints moving."""
    translation, rotations = movement(FRAMES, seed=5, up="y")
    moved = of_default_body(translation + np.array([0.0, 0.9, 0.0]), rotations)
    return Clip(SOMA[77].offsets, moved.hips, moved.local)


def test_it_is_the_motion_of_the_same_clip_in_kimodos_npz(tmp_path):
    path = gemx(tmp_path / "hpe_results.pt", clip())
    assert identify(Source(path)).name == "gem-x"
    found = quiet(path).motion
    truth = quiet(kimodo(tmp_path / "a.npz", clip())).motion
    assert np.abs(found.rotations - truth.rotations).max() < SINGLE
    assert np.abs(found.translation - truth.translation).max() < SINGLE
    assert found.fps == 30.0
    part = quiet(path, frames=(3, 9)).motion
    assert np.array_equal(part.rotations, found.rotations[3:9])


def test_other_names_and_shapes_of_the_same(tmp_path):
    data = gemx_data(clip())
    truth = quiet(torch_dict(tmp_path / "a.pt", data)).motion
    data = {f"pred_{key}": value for key, value in data.items()}
    fields = data["pred_body_params_global"]
    fields["body_pose"] = fields["body_pose"].reshape(FRAMES, 76, 3)
    found = quiet(torch_dict(tmp_path / "b.pt", data)).motion
    assert np.array_equal(found.rotations, truth.rotations)


def test_the_camera_alone_is_turned_upright(tmp_path):
    data = gemx_data(clip())
    truth = quiet(torch_dict(tmp_path / "a.pt", data)).motion
    del data["body_params_global"]
    with pytest.warns(HalfPhysicsWarning, match="frame of the camera.*turned upright"):
        found = hp.Motion.load(torch_dict(tmp_path / "b.pt", data))
    own, other = (hp.Body.default().joints(motion) for motion in (found, truth))
    # The camera looks along +z, the world's is at the origin with y up: turned about x by pi.
    assert np.abs(own - other).max() < SINGLE


def test_what_is_invented_is_said_once_and_kept(tmp_path):
    path = gemx(tmp_path / "a.pt", clip())
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        motion = hp.Motion.load(path)
    invented = motion.origin.fields["invented"]
    assert set(invented) == {"fps", "floor", "betas"}
    assert all(told in str(said[0].message) for told in invented.values())
    again = quiet(path, fps=50.0).motion
    assert again.fps == 50.0
    assert "fps" not in again.origin.fields["invented"]


def test_poses_of_smplx_are_read_as_gvhmrs(tmp_path):
    data = video_files.gvhmr_data(person("3", np.arange(12), 1, 22))
    truth = quiet(torch_dict(tmp_path / "a.pt", data)).motion
    data = {key.replace("smpl_params", "body_params"): value for key, value in data.items()}
    path = torch_dict(tmp_path / "smpl_params.pt", data)
    assert identify(Source(path)).name == "gem-x"
    found = quiet(path).motion
    assert np.array_equal(found.rotations, truth.rotations)
    assert np.array_equal(found.translation, truth.translation)
    assert np.array_equal(found.betas, truth.betas)
    assert set(found.origin.fields["invented"]) == set(truth.origin.fields["invented"])


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without("body_pose"), "'body_pose' is missing"),
        (without("global_orient"), "'global_orient' is missing"),
        (without("transl"), "'transl' is missing"),
        (changed("body_pose", lambda a: a[:, :-3]), r"'body_pose'.*228\) of SOMA or .T, 63"),
        (changed("body_pose", lambda a: a.reshape(-1)), "'body_pose'.*expected"),
        (changed("transl", lambda a: a[:, :2]), "'transl'.*expected"),
        (changed("transl", lambda a: a[:-2]), "different length"),
        (spoilt("body_pose", (3, 0), np.nan), "'body_pose'.*NaN.*frame 3"),
        (spoilt("transl", (4, 1), np.inf), "'transl'.*infinite.*frame 4"),
        (changed("transl", lambda a: a[:0]), "different length"),
    ],
)
def test_wrong_files(tmp_path, spoil, message):
    data = gemx_data(clip())
    spoil(data["body_params_global"])
    refused(torch_dict(tmp_path / "a.pt", data), message)


def test_files_that_are_none(tmp_path):
    data = gemx_data(clip())
    data["body_params_global"] = data["K_fullimg"]
    refused(torch_dict(tmp_path / "a.pt", data), "'body_params_global'.*expected a dict")
    data = gemx_data(clip())
    for fields in (data["body_params_global"], data["body_params_incam"]):
        for key, value in fields.items():
            fields[key] = value[:0]
    refused(torch_dict(tmp_path / "b.pt", data), "frame")
    broken_bytes_are_refused(gemx(tmp_path / "c.pt", clip()))
