"""Files of joint positions that are written: the joints of the body, as others read them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import axes_of
from halfphysics.errors import InputError
from halfphysics.formats import losses
from support.files.layouts import movement
from support.files.position_files import offsets, places, y_up

pytestmark = pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")

#: Positions in single precision [m].
SINGLE = 1e-6
#: Positions of anything, as joints that bend as a person's meet them [m].
NEAR = 0.02


@pytest.fixture
def motion():
    return hp.Motion(*movement(9), 20.0)


def truth(motion: hp.Motion) -> np.ndarray:
    """Positions (T, 22, 3), y up, by forward kinematics of rotation matrices."""
    rest = np.asarray(hp.Body.default().rest_joints)
    found = places(motion.rotations, motion.translation + rest[0], offsets(rest))
    return y_up(found[:, :22])


def test_an_array_of_joints(motion, tmp_path):
    motion.save(tmp_path / "a.npy", format="joints", body=hp.Body.default())
    found = np.load(tmp_path / "a.npy")
    assert found.dtype == np.float32
    assert np.abs(found - truth(motion)).max() < SINGLE


def test_a_run_of_mdm(motion, tmp_path):
    motion.save(tmp_path / "a.npy", format="mdm", body=hp.Body.default())
    run = np.load(tmp_path / "a.npy", allow_pickle=True)[()]  # the test's own file
    assert run["motion"].shape == (1, 22, 3, 9)
    assert np.abs(np.moveaxis(run["motion"][0], -1, 0) - truth(motion)).max() < SINGLE
    assert run["lengths"].tolist() == [9]
    assert (run["num_samples"], run["num_repetitions"], run["text"]) == (1, 1, [""])


@pytest.mark.parametrize("format", ["joints", "mdm"])
@pytest.mark.parametrize("up", ["y", "z"])
def test_a_file_is_written_back_in_its_own_axes(motion, tmp_path, format, up):
    body, joints = hp.Body.default(), truth(motion)
    places = joints @ axes_of("y").T if up == "z" else joints
    content = {"motion": np.moveaxis(places, 0, -1)[None], "lengths": np.array([9])}
    np.save(tmp_path / "a.npy", content if format == "mdm" else places, allow_pickle=True)
    first = hp.Motion.load(tmp_path / "a.npy", up=up)
    assert first.origin.format == format
    first.save(tmp_path / "b.npy", body=body)
    found = np.load(tmp_path / "b.npy", allow_pickle=True)
    found = np.moveaxis(found[()]["motion"][0], -1, 0) if format == "mdm" else found
    assert np.abs(found - places).max() < NEAR


def test_the_text_of_a_run_comes_back(motion, tmp_path):
    motion.save(tmp_path / "a.npy", format="mdm", body=hp.Body.default())
    run = np.load(tmp_path / "a.npy", allow_pickle=True)[()]
    whole = np.array({**run, "text": ["a person waves"]}, dtype=object)
    np.save(tmp_path / "b.npy", whole, allow_pickle=True)
    hp.Motion.load(tmp_path / "b.npy").save(tmp_path / "c.npy", body=hp.Body.default())
    again = np.load(tmp_path / "c.npy", allow_pickle=True)[()]
    assert again["text"] == ["a person waves"]


def test_rotations_that_mdm_fits(motion, tmp_path):
    motion.save(tmp_path / "a.npy", format="mdm-smpl", body=hp.Body.default())
    found = pickle.loads(pickle.dumps(np.load(tmp_path / "a.npy", allow_pickle=True)[()]))
    assert found["thetas"].shape == (24, 6, 9)
    assert np.abs(found["root_translation"].T - truth(motion)[:, 0]).max() < SINGLE
    assert np.array_equal(found["motion"][:24], found["thetas"])
    assert np.array_equal(found["motion"][24, :3], found["root_translation"])


def test_joints_need_a_body_and_lose_twist(motion, tmp_path):
    upright = hp.Motion.from_smplx(
        fps=20.0, up="y", transl=np.zeros((9, 3)), global_orient=np.zeros((9, 3))
    )
    with pytest.raises(InputError, match=r"'joints' holds the joints of the person.*body="):
        upright.save(tmp_path / "a.npy", format="joints")
    assert not list(tmp_path.iterdir())
    lost = losses(motion.resample(30.0), tmp_path / "a.npy", "joints")
    assert lost[0] == "turns of bones about themselves"
    assert lost[-1] == "the frame rate 30: readers take 20; say motion.resample(20)"
