"""What is written into files of estimators, field by field, against what their programs write."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import torch_file
from halfphysics.formats import losses, save_people
from halfphysics.motion import skeleton
from support.files import video_files as files
from support.files.dumps import torch_dict
from support.files.video_files import two

pytestmark = pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")

#: Numbers of files in single precision, and rotation vectors of two conversions.
SINGLE = 1e-6


def content(path):
    if path.suffix == ".pt":
        return torch_file.read(path)
    with path.open("rb") as handle:
        return pickle.load(handle)  # the test's own file


def written(source, tmp_path, clips):
    """The people of a file, each read alone with all of their frames, written into one."""
    motions = [hp.Motion.load(source, clip=clip) for clip in clips]
    (path,) = save_people(motions, tmp_path / f"out{source.suffix}", [None] * len(motions))
    return content(path)


def same(found, asked, rows=slice(None)):
    assert np.abs(np.asarray(found)[rows] - asked).max() < SINGLE


def seen_rows(who):
    """Rows of the frames in which somebody was seen, in a file without gaps."""
    return who.frames - who.frames[0]


def test_wham(tmp_path):
    people = two(22)
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(people))
    found, asked = written(source, tmp_path, ["3", "8"]), files.wham_data(people)
    assert list(found) == [3, 8]
    for who in people:
        own, rows = found[int(who.name)], seen_rows(who)
        assert own["frame_ids"].tolist() == list(range(who.frames[0], who.frames[-1] + 1))
        for key in ("pose_world", "trans_world"):
            same(own[key], asked[int(who.name)][key], rows)
        same(own["betas"], np.tile(who.betas, (len(own["betas"]), 1)))


def test_prompthmr(tmp_path):
    people = two()
    source = files.joblib_file(tmp_path / "results.pkl", files.prompthmr_data(people))
    found = written(source, tmp_path, ["3", "8"])["people"]
    asked = files.prompthmr_data(people)["people"]
    assert list(found) == [3, 8]
    for who, truth in zip(people, asked.values(), strict=True):
        own, rows = found[int(who.name)], seen_rows(who)
        assert own["track_id"] == int(who.name)
        assert own["frames"][rows].tolist() == who.frames.tolist()
        for key in ("pose", "trans"):
            same(own["smplx_world"][key], truth["smplx_world"][key], rows)


def test_comotion(tmp_path):
    people = two(22)
    source = torch_dict(tmp_path / "clip.pt", files.comotion_data(people))
    found, asked = written(source, tmp_path, ["3", "8"]), files.comotion_data(people)
    assert found["id"].dtype == np.int64
    for who in people:
        own, theirs = found["id"] == int(who.name), asked["id"] == int(who.name)
        rows = seen_rows(who)
        assert found["frame_idx"][own][rows].tolist() == who.frames.tolist()
        for key in ("pose", "trans"):
            same(found[key][own], asked[key][theirs], rows)


def test_gvhmr_in_the_world_and_before_a_camera(tmp_path):
    (who, _) = two(22)
    for key in ("smpl_params_global", "smpl_params_incam"):
        asked = {key: files.gvhmr_data(who)[key]}
        source = torch_dict(tmp_path / "hmr4d_results.pt", asked)
        found = written(source, tmp_path, [None])
        assert list(found) == [key]
        for name, values in asked[key].items():
            if name != "betas":
                same(found[key][name], values)


def test_frames_that_were_cut_keep_their_numbers(tmp_path):
    source = files.joblib_file(tmp_path / "wham_output.pkl", files.wham_data(two(22)))
    motion = hp.Motion.load(source, clip="8", frames=(3, None))
    motion.save(tmp_path / "out.pkl")
    (own,) = content(tmp_path / "out.pkl").values()
    assert own["frame_ids"].tolist() == list(range(9, 14))


def test_what_such_a_file_cannot_hold_is_said(tmp_path):
    rotations = np.zeros((3, 55, 3))
    rotations[:, skeleton.LEFT_HAND_JOINTS[0]] = 0.3
    motion = hp.Motion(np.zeros((3, 3)), rotations, 60.0, betas=np.ones(16), gender="female")
    assert losses(motion, tmp_path / "a.pt", "gvhmr") == [
        "the fingers",
        "the gender 'female'",
        "betas beyond the first 10",
        "the frame rate 60: readers take 30; say --to-fps 30",
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert losses(motion, tmp_path / "a.pkl", "prompthmr")[0] == "the gender 'female'"
