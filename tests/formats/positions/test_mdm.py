"""MDM's results.npy: clips by sample and repetition, their lengths, positions and rotations."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import halfphysics as hp
from support.files.layouts import movement, quiet
from support.files.position_files import offsets, places, rows
from support.files.wrong_files import (
    changed,
    hostile_is_refused,
    put,
    refused,
    spoilt,
    uneven,
    without,
)

MET = 2e-3  # metres, mean over joints and frames
ROUNDING = 1e-6
REST = np.asarray(hp.Body.default().rest_joints)
FRAMES, LENGTHS = 30, (30, 20, 25, 12)
PELVIS = np.array([0.0, 0.9, 0.0])


def parts(seed):
    translation, rotations = movement(FRAMES, seed, up="y")
    rotations = np.array(rotations)
    rotations[:, 22:] = 0.0
    return translation + PELVIS, rotations


def truth(seed):
    pelvis, rotations = parts(seed)
    return places(rotations, pelvis, offsets(REST, 22))


def fields():
    motions = [np.moveaxis(truth(k), 0, -1) for k in range(4)]
    return {
        "motion": np.stack(motions).astype(np.float32),
        "text": ["walk", "sit", "jump", "turn"],
        "lengths": np.array(LENGTHS),
        "num_samples": 2,
        "num_repetitions": 2,
    }


def written(path, content):
    np.save(path, content, allow_pickle=True)
    return path


def z_up(points):
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def test_clips(tmp_path):
    path = written(tmp_path / "results.npy", fields())
    clips = list(hp.clips(path))
    names = ["sample00_rep00", "sample01_rep00", "sample00_rep01", "sample01_rep01"]
    assert [clip.name for clip in clips] == names
    for k, clip in enumerate(clips):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sequence = clip.load()
        assert len(sequence.motion) == LENGTHS[k]
        assert sequence.motion.fps == 20.0
        own = sequence.bodies[0].joints(sequence.motion)[:, :22]
        expected = z_up(truth(k)[: LENGTHS[k]])
        assert np.linalg.norm(own - expected, axis=2).mean() < MET
        assert sequence.motion.origin.fields["text"] == fields()["text"][k]


def test_rotations_of_other_models(tmp_path):
    """(N, 25, 6, T): rows of matrices, then the place of the pelvis."""
    pelvis, rotations = parts(3)
    content = np.zeros((1, 25, 6, FRAMES))
    content[0, :24] = np.moveaxis(rows(np.pad(rotations[:, :22], [(0, 0), (0, 2), (0, 0)])), 0, -1)
    content[0, 24, :3] = pelvis.T
    path = written(tmp_path / "a.npy", {**fields(), "motion": content, "lengths": np.array([30])})
    motion = quiet(path).motion
    own = hp.Body.default().joints(motion)[:, :22]
    assert np.abs(own - z_up(truth(3))).max() < ROUNDING


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without("lengths"), "no known motion format"),
        (changed("lengths", lambda a: a[:2]), "'lengths'.*expected"),
        (changed("lengths", lambda a: a * 9), "'lengths'.*expected 1 to 30"),
        (changed("motion", lambda a: a[:, :20]), "'motion'.*expected"),
        (changed("motion", lambda a: np.moveaxis(a, 3, 1)), "'motion'.*expected"),
        (spoilt("motion", (0, 3, 1, 4), np.nan), "'motion'.*NaN.*frame 4"),
        (put("motion", "walk"), "'motion'.*expected"),
        uneven("motion")[1:],
        (put("motion", np.zeros((0, 22, 3, 30))), "holds no clips, expected at least one"),
        (put("num_samples", 0.5), "'num_samples': found 0.5, expected a whole number above 0"),
        (put("num_samples", -2), "'num_samples'.*expected a whole number above 0"),
    ],
)
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "a.npy", content), message, clip="sample00_rep00")


def test_hostile(tmp_path):
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps(fields()))
    hostile_is_refused(path, fields(), "text", clip="sample00_rep00")
