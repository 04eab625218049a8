"""HumanML3D's features: joints come back, normalized ones with their statistics."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats.positions.humanml import positions_of
from halfphysics.formats.positions.layouts import LAYOUTS
from support.files.layouts import movement, quiet
from support.files.position_files import STRANGER, features, first_heading, places
from support.files.wrong_files import refused

MET = 2e-3  # metres, mean over joints and frames
EXACT = 1e-9
FRAMES = 60


def truth(seed=0):
    """Positions of a person who walks and turns, y up."""
    translation, rotations = movement(FRAMES, seed, up="y")
    rotations = np.array(rotations)
    t = np.arange(FRAMES) / 20.0
    way = translation + np.stack([0.8 * t, 0.9 + 0.0 * t, 0.3 * t], axis=1)
    return places(rotations, way, STRANGER)


def statistics(count=263):
    rng = np.random.default_rng(5)
    return rng.normal(0.1, 0.3, count), rng.uniform(0.05, 0.4, count)


def z_up(points):
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def met(sequence, positions):
    own = sequence.bodies[0].joints(sequence.motion)[:, :22]
    return np.linalg.norm(own - z_up(positions), axis=2).mean() < MET


def test_features_give_the_joints():
    joints = truth()
    assert np.abs(positions_of(features(joints)) - first_heading(joints)[:-1]).max() < EXACT


def test_read(tmp_path):
    path = tmp_path / "000021.npy"
    np.save(path, features(truth()).astype(np.float32))
    sequence = quiet(path)
    assert met(sequence, first_heading(truth())[:-1])
    assert sequence.motion.fps == 20.0
    # Frames are cut after the way is summed up.
    assert met(quiet(path, frames=(20, 40)), first_heading(truth())[20:40])


def test_kit(tmp_path):
    full = truth()
    joints = np.zeros((FRAMES, 21, 3))
    for column, joint in enumerate(LAYOUTS[21]):
        joints[:, column] = full[:, joint if joint >= 0 else 0]
    for ankle in (13, 18):
        joints[:, ankle + 1] = 0.5 * (joints[:, ankle] + joints[:, ankle + 2])
    # Joints 1 and 2 say the heading in `features`: the hips of KIT are 16 and 11.
    order = np.arange(21)
    order[[1, 2, 16, 11]] = 16, 11, 1, 2
    numbers = features(joints[:, order])
    block = numbers[:, 4:64].reshape(-1, 20, 3)
    numbers[:, 4:64] = block[:, order[1:] - 1].reshape(-1, 60)
    path = tmp_path / "kit.npy"
    np.save(path, numbers)
    assert numbers.shape[1] == 251
    motion = quiet(path).motion
    assert motion.fps == 12.5
    assert len(motion) == FRAMES - 1


def test_normalized_features_need_their_statistics(tmp_path):
    mean, spread = statistics()
    folder = tmp_path / "set" / "vecs"
    folder.mkdir(parents=True)
    path = folder / "a.npy"
    np.save(path, (features(truth()) - mean) / spread)
    refused(path, "normalized.*Mean.npy and Std.npy")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    for where, options in ((tmp_path / "set", {}), (elsewhere, {"assets": elsewhere})):
        np.save(where / "Mean.npy", mean)
        np.save(where / "Std.npy", spread)
        with pytest.warns(hp.HalfPhysicsWarning, match="un-normalized with Mean.npy"):
            sequence = hp.load_sequence(path, **options)
        assert met(sequence, first_heading(truth())[:-1])
        (where / "Mean.npy").unlink()
    np.save(tmp_path / "set" / "Mean.npy", mean[::-1])
    np.save(tmp_path / "set" / "Std.npy", 9.0 * spread)
    refused(path, "neither as they are nor with")
    np.save(tmp_path / "set" / "Std.npy", spread[:9])
    with pytest.raises(hp.HalfPhysicsError, match="expected numbers"):
        hp.Motion.load(path)


def test_clips(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.stack([features(truth(k)) for k in range(2)]))
    for k, clip in enumerate(hp.clips(path)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert met(clip.load(), first_heading(truth(k))[:-1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda f: f[:0], "found no frames"),
        (lambda f: f[:1], "expected at least 2"),
        (lambda f: np.where(np.arange(263) == 3, np.nan, f), "NaN"),
        (lambda f: 0.0 * f, "normalized"),
        (lambda f: f[:, ::-1], "normalized"),
        (lambda f: f[:, :262], "no known motion format"),
    ],
)
def test_wrong_files(tmp_path, change, message):
    path = tmp_path / "a.npy"
    np.save(path, change(features(truth())))
    refused(path, message)
