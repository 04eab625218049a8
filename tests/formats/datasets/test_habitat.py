"""Habitat's humanoid motions: files as its converter writes them, other orders, and wrong files."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.errors import FileError
from halfphysics.formats.datasets.habitat import ORDER
from halfphysics.motion.skeleton import JOINT_NAMES, PARENTS
from support.live_frames import BODY, UPRIGHT, furthest

FRAMES = 5
pytestmark = pytest.mark.filterwarnings("ignore::halfphysics.errors.HalfPhysicsWarning")


def rotations_of(seed=1):
    """Of an upright person who bends and turns (T, 55, 3), z-up."""
    rotations = np.random.default_rng(seed).normal(scale=0.4, size=(FRAMES, 55, 3))
    rotations[:, 0] = UPRIGHT + 0.1 * rotations[:, 0]
    return rotations


def habitats(rotations, places, order=ORDER, fps=30.0):
    """A clip as Habitat's converter makes it: the world turned so that z becomes y, x becomes -z.

    `global_correction_quat(z_axis, x_axis)` of habitat/utils/humanoid_utils.py, with scipy.
    """
    correction = Rotation.from_matrix([[0, -1, 0], [0, 0, 1], [-1, 0, 0]])
    transforms = np.tile(np.eye(4), (FRAMES, 1, 1))
    roots = correction * Rotation.from_rotvec(rotations[:, 0])
    transforms[:, :3, :3] = roots.as_matrix()
    transforms[:, :3, 3] = correction.apply(places)
    joints = np.stack([Rotation.from_rotvec(rotations[:, j]).as_quat() for j in order], axis=1)
    return {
        "joints_array": joints.reshape(FRAMES, -1),
        "transform_array": transforms,
        "displacement": None,
        "fps": fps,
    }


def written(path, clip, name="pose_motion"):
    path.write_bytes(pickle.dumps({name: clip}))
    return path


def turned(rotations):
    """The root as it is read: Habitat's -z, which was +x, is our +y."""
    turn = Rotation.from_euler("z", 90, degrees=True)
    out = rotations.copy()
    out[:, 0] = (turn * Rotation.from_rotvec(rotations[:, 0].copy())).as_rotvec()
    return out


@pytest.mark.parametrize("name", ["pose_motion", "walk_motion"])
def test_what_their_converter_writes_is_read(tmp_path, name):
    rotations = rotations_of()
    places = np.random.default_rng(2).normal(scale=0.02, size=(FRAMES, 3))
    places[:, 2] += 0.9
    motion = hp.Motion.load(written(tmp_path / "a.pkl", habitats(rotations, places), name))
    assert motion.fps == 30.0
    assert np.allclose(BODY.joints(motion)[:, 0], places @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    expected = hp.Motion(motion.translation, turned(rotations), 30.0, axes=motion.axes)
    for k in range(FRAMES):
        assert furthest(motion[k], expected[k]) < 1e-4


def test_ours_comes_back(tmp_path):
    motion = hp.Motion(np.random.default_rng(3).normal(size=(FRAMES, 3)) / 50, rotations_of(), 25.0)
    motion.save(tmp_path / "a.pkl", format="habitat", body=BODY)
    clip = pickle.loads((tmp_path / "a.pkl").read_bytes())["pose_motion"]
    assert clip["joints_array"].shape == (FRAMES, 216)
    assert clip["transform_array"].shape == (FRAMES, 4, 4)
    assert clip["displacement"].shape == (FRAMES,)
    again = hp.Motion.load(tmp_path / "a.pkl")
    assert again.fps == 25.0
    assert max(furthest(again[k], motion[k]) for k in range(FRAMES)) < 1e-4
    assert np.allclose(BODY.joints(again), BODY.joints(motion), atol=1e-6)


def urdf(names):
    joints = "".join(
        f'<link name="{name}"/><joint name="{name}" type="spherical">'
        f'<parent link="{JOINT_NAMES[PARENTS[JOINT_NAMES.index(name)]]}"/>'
        f'<child link="{name}"/></joint>'
        for name in names
    )
    return f'<robot name="h"><link name="pelvis"/>{joints}</robot>'


def test_the_order_of_a_urdf(tmp_path):
    """Spine before legs: another order, which the URDF beside the file tells."""
    spine = JOINT_NAMES.index("spine1")
    first = [j for j in ORDER if j in (spine,) or _below(j, spine)]
    order = [*first, *(j for j in ORDER if j not in first)]
    (tmp_path / "model").mkdir()
    names = [JOINT_NAMES[j] for j in order]
    (tmp_path / "model" / "female_2.urdf").write_text(urdf(names))
    path = written(tmp_path / "a.pkl", habitats(rotations_of(), np.zeros((FRAMES, 3)), order))
    motion = hp.load_sequence(path, assets=tmp_path / "model").motion
    expected = hp.Motion(motion.translation, turned(rotations_of()), 30.0, axes=motion.axes)
    assert max(furthest(motion[k], expected[k]) for k in range(FRAMES)) < 1e-4
    (tmp_path / "model" / "female_2.urdf").write_text(urdf(names[:50]))
    with pytest.raises(FileError, match="found 50 spherical joints"):
        hp.load_sequence(path, assets=tmp_path / "model")
    (tmp_path / "model" / "female_2.urdf").write_text('<!DOCTYPE r [<!ENTITY a "b">]><r/>')
    with pytest.raises(FileError, match="entities"):
        hp.load_sequence(path, assets=tmp_path / "model")


def _below(joint, above):
    while joint >= 0:
        joint = int(PARENTS[joint])
        if joint == above:
            return True
    return False


def test_their_rate_of_one_is_none(tmp_path):
    clip = habitats(rotations_of(), np.zeros((FRAMES, 3)), fps=1)
    path = written(tmp_path / "a.pkl", clip)
    assert hp.Motion.load(path, fps=60.0).fps == 60.0


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("joints_array", np.zeros((FRAMES, 216)), "quaternions of zeros"),
        ("joints_array", np.zeros((FRAMES, 100)), "joints_array"),
        ("joints_array", np.full((FRAMES, 216), np.nan), "NaN"),
        ("transform_array", np.zeros((FRAMES, 4, 4)), "no rotation and place"),
        ("transform_array", np.zeros((FRAMES - 1, 4, 4)) + np.eye(4), "frames"),
    ],
)
def test_wrong_files(tmp_path, key, value, message):
    clip = habitats(rotations_of(), np.zeros((FRAMES, 3))) | {key: value}
    with pytest.raises(FileError, match=message):
        hp.Motion.load(written(tmp_path / "a.pkl", clip))
