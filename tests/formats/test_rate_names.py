"""The frame rate of a file under the names that are about."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError
from halfphysics.formats.checked_fields import Record
from halfphysics.formats.rate_names import is_rate, rate_keys, said_rate
from support.files.amass_files import fields, write
from support.files.layouts import movement, quiet

NAMES = ["fps", "FPS", "framerate", "frame_rate", "frameRate", "mocap_fps", "mocap_framerate",
         "mocap_frame_rate", "mocapFrameRate", "video_fps"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_every_name_is_read_and_written_back(tmp_path, name):
    content = fields("smplh")
    del content["mocap_framerate"]
    path = write(tmp_path / "a.npz", content | {name: np.array(120.0)})
    motion = hp.Motion.load(path)  # a warning would be an error
    assert motion.fps == 120.0
    motion.resample(60.0).save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:
        assert out[name] == 60.0
        assert [key for key in out if is_rate(key)] == [name]


@pytest.mark.parametrize("name", NAMES)
def test_dumps_of_parameters_say_it_too(tmp_path, name):
    translation, turns = movement(12, up="y")
    body = turns[:, 1:22].reshape(12, 63)
    person = {"global_orient": turns[:, 0], "body_pose": body, "transl": translation}
    for content in (person | {name: 60}, {"anne": person, name: np.array([60.0])}):
        (tmp_path / "a.pkl").write_bytes(pickle.dumps(content))
        assert quiet(tmp_path / "a.pkl").motion.fps == 60.0


def test_no_rate_is_none_and_what_is_no_rate_is_refused():
    assert said_rate(Record("f", {"fps": None, "frames": 12})) is None
    assert said_rate(Record("f", {"fps": None, "frame_rate": 25})) == 25.0
    with pytest.raises(FileError, match="'frame_rate': found -1, expected a number"):
        said_rate(Record("f", {"frame_rate": -1}))
    assert not any(is_rate(name) for name in ("frame", "frames", "frame_ids", "rate", 7))


def test_the_name_that_a_format_has_counts_first_and_that_of_a_video_last():
    assert rate_keys(["fps", "mocap_framerate"], ("fps",)) == ["fps", "mocap_framerate"]
    assert rate_keys(["trans", "video_fps", "fps"]) == ["fps", "video_fps"]
    assert rate_keys(["trans"], ("fps",)) == []


def test_of_several_rates_the_motions_own_counts(tmp_path):
    translation, turns = movement(12, up="y")
    person = {
        "global_orient": turns[:, 0],
        "body_pose": turns[:, 1:22].reshape(12, 63),
        "transl": translation,
    }
    for content in (
        {"video_fps": 30, **person, "mocap_frame_rate": 120},
        {"video_fps": 30, "anne": {**person, "frame_rate": 120}},
        {"fps": 30, "anne": {**person, "video_fps": 120}},
    ):
        (tmp_path / "a.pkl").write_bytes(pickle.dumps(content))
        assert quiet(tmp_path / "a.pkl").motion.fps == 120.0


def test_rates_of_amass_that_are_not_taken_are_fields_like_others(tmp_path):
    others = {"video_fps": np.arange(20.0), "frame_rate": np.array(60.0), "ID": np.array("a")}
    path = write(tmp_path / "a.npz", fields("smplh") | others)
    motion = hp.Motion.load(path)
    assert motion.fps == fields("smplh")["mocap_framerate"]
    motion.save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:
        assert all(np.array_equal(out[key], value) for key, value in others.items())
    motion.resample(0.5 * motion.fps).save(tmp_path / "b.npz")
    with np.load(tmp_path / "b.npz") as out:  # the video has its rate, the motion another
        assert "frame_rate" not in out
        assert np.array_equal(out["video_fps"], others["video_fps"])


def test_a_rate_that_is_none_hides_no_other(tmp_path):
    content = fields("smplh") | {"mocap_framerate": np.array(None, dtype=object), "fps": 60.0}
    assert hp.Motion.load(write(tmp_path / "a.npz", content)).fps == 60.0


@pytest.mark.parametrize("odd", [np.array("30fps"), np.zeros(0)])
def test_a_rate_that_is_none_of_amass_is_overridden_and_written_anew(tmp_path, odd):
    path = write(tmp_path / "a.npz", fields("smplh") | {"mocap_framerate": odd})
    hp.Motion.load(path, fps=30.0).save(tmp_path / "b.npz")
    assert hp.Motion.load(tmp_path / "b.npz").fps == 30.0
