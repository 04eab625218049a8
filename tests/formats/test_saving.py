"""Which format a motion is written in, and people into one file or one each."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base import torch_file
from halfphysics.errors import InputError
from halfphysics.formats import FORMATS, losses, save_people, writer_of
from support.files import position_files
from support.files import video_files as files
from support.files.dumps import torch_dict
from support.files.layouts import movement
from support.files.video_files import two

pytestmark = pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")


@pytest.fixture
def motion():
    """Somebody upright, without fingers, jaw and eyes."""
    translation, rotations = movement(6)
    rotations[:, 22:] = 0.0
    return hp.Motion(translation, rotations, 30.0)


@pytest.mark.parametrize(
    ("name", "format"),
    [
        ("a.npz", "amass-smplx"),
        ("a", "amass-smplx"),
        ("a.pkl", "smplx-params"),
        ("a.pt", "smplx-params"),
        ("a.JSON", "smplx-params"),
        ("a.bvh", "bvh"),
    ],
)
def test_a_motion_of_no_file_goes_by_suffix(motion, tmp_path, name, format):
    assert writer_of(motion, tmp_path / name, None).name == format


def test_a_motion_of_a_file_goes_back_as_it_came(tmp_path):
    (who, _) = two(22)
    read = hp.Motion.load(files.gvhmr(tmp_path / "hmr4d_results.pt", who))
    assert writer_of(read, tmp_path / "a.pt", None).name == "gvhmr"
    assert writer_of(read, tmp_path / "a.npz", None).name == "amass-smplx"
    read = hp.Motion.load(files.smplerx(tmp_path / "clip", [who]))  # its folders are read only
    assert writer_of(read, tmp_path / "a.pkl", None).name == "smplx-params"


def stepping() -> hp.Motion:
    """Somebody who stands on the floor and sways."""
    rotations = np.zeros((8, 55, 3))
    rotations[:, 0, 0] = np.pi / 2.0
    rotations[:, 3, 2] = np.linspace(-0.2, 0.2, 8)
    return hp.Motion(np.zeros((8, 3)), rotations, 20.0).grounded(hp.Body.default())


def test_a_format_may_name_another_to_write(tmp_path):
    for name, format in FORMATS.items():
        if format.instead:
            assert format.save is None, name
            assert FORMATS[format.instead].save is not None, name
    joints = hp.Body.default().joints(stepping())[:, :22]
    np.save(tmp_path / "a.npy", position_files.features(position_files.y_up(joints)))
    read = hp.Motion.load(tmp_path / "a.npy")
    assert read.origin.format == "humanml3d"
    assert writer_of(read, tmp_path / "b.npy", None).name == "joints"


def test_people_go_into_one_file_or_one_each(motion, tmp_path):
    other = hp.Motion(*movement(6, seed=5), 30.0)
    assert save_people([motion, other], tmp_path / "both.pkl", [None, None]) == [
        tmp_path / "both.pkl"
    ]
    for clip, asked in (("0", motion), ("1", other)):
        back = hp.Motion.load(tmp_path / "both.pkl", clip=clip)
        assert np.abs(back.rotations - asked.rotations).max() < 1e-12
    paths = save_people([motion, other], tmp_path / "each.npz", [None, None])
    assert [path.name for path in paths] == ["each_1.npz", "each_2.npz"]
    assert np.allclose(hp.Motion.load(paths[1]).translation, other.translation)


@pytest.mark.parametrize("suffix", [".pkl", ".pt", ".json"])
def test_plain_parameters_say_their_axes_and_rate(motion, tmp_path, suffix):
    """Other programs read them without this package: nothing but numbers, under smplx's names."""
    motion = hp.Motion(motion.translation, motion.rotations, 50.0, gender="male")
    path = tmp_path / f"a{suffix}"
    motion.save(path, body=hp.Body.default())
    if suffix == ".json":
        found = json.loads(path.read_text())
    elif suffix == ".pt":
        found = torch_file.read(path)
    else:
        found = pickle.loads(path.read_bytes())  # the test's own file
    shapes = {key: np.shape(value) for key, value in found.items() if np.ndim(value)}
    assert shapes["body_pose"] == (6, 63)
    assert shapes["right_hand_pose"] == (6, 45)
    assert (found["fps"], found["gender"], found["up"]) == (50.0, "male", "z")
    back = hp.Motion.load(path)
    assert (back.fps, back.gender) == (50.0, "male")
    body = hp.Body.default()
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < 1e-5


def test_axes_between_those_of_files_are_turned_upright(motion, tmp_path):
    """As of SLAHMR, whose floor may lie in any direction."""
    turn = rot.rotvec_to_matrix(np.array([0.3, 0.1, -0.2]))
    tilted = hp.Motion(motion.translation, motion.rotations, 30.0, axes=turn)
    tilted.save(tmp_path / "a.pkl")
    back, body = hp.Motion.load(tmp_path / "a.pkl"), hp.Body.default()
    assert np.abs(body.vertices(back) - body.vertices(tilted)).max() < 1e-9


def test_pickles_are_for_every_numpy(motion, tmp_path):
    """numpy 2 names its core so that numpy 1, with which estimators run, finds nothing."""
    for name, format in (("a.pkl", "wham"), ("b.npz", "romp"), ("c.npy", "mdm")):
        motion.save(tmp_path / name, format=format, body=hp.Body.default())
        raw = (tmp_path / name).read_bytes()
        assert b"numpy.core.multiarray" in raw
        assert b"numpy._core" not in raw


def test_bones_of_a_person_are_said_to_be_lost(motion, tmp_path):
    bones = np.full((55, 3), np.nan)
    bones[4] = [0.0, -0.5, 0.0]
    body = hp.Body.default(bones=bones)
    told = [line for line in losses(motion, tmp_path / "a.npz", body=body) if "own bones" in line]
    assert len(told) == 1
    assert not any("bones (" in line for line in losses(motion, tmp_path / "a.bvh", body=body))
    assert losses(motion, tmp_path / "a.npz", body=hp.Body.default()) == []


def test_three_people_do_not_fit_a_file_of_two(motion, tmp_path):
    with pytest.raises(InputError, match="holds two people, found 3"):
        save_people([motion] * 3, tmp_path / "a.pkl", [None] * 3, format="interhuman")
    assert not list(tmp_path.iterdir())


def test_read_only_formats_are_named(motion, tmp_path):
    with pytest.raises(InputError, match="'smplerx' can only be read, expected one of"):
        writer_of(motion, tmp_path / "a.pkl", "smplerx")
    with pytest.raises(InputError, match=r"found suffix '\.txt'"):
        writer_of(motion, tmp_path / "a.txt", None)


def test_a_torch_file_of_a_person_is_the_same_every_time(motion, tmp_path):
    for name in ("a.pt", "b.pt"):
        motion.save(tmp_path / name, format="gvhmr", body=hp.Body.default())
    assert (tmp_path / "a.pt").read_bytes() == (tmp_path / "b.pt").read_bytes()
    again = torch_dict(tmp_path / "c.pt", torch_file.read(tmp_path / "a.pt"))
    found, asked = torch_file.read(again), torch_file.read(tmp_path / "a.pt")
    for key, values in asked["smpl_params_global"].items():
        assert np.array_equal(found["smpl_params_global"][key], values)
