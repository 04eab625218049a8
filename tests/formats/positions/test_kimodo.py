"""Kimodo's own npz: SMPL-X by rotations, on the bones of its joints; other skeletons are named."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import halfphysics as hp
from support.files.layouts import movement, quiet
from support.files.position_files import STRANGER, matrices, places
from support.files.wrong_files import changed, refused, spoilt, without

ROUNDING = 1e-5  # metres, of single precision
FRAMES = 24
PELVIS = np.array([0.0, 0.9, 0.0])


def truth():
    translation, rotations = movement(FRAMES, up="y")
    rotations = np.array(rotations)
    rotations[:, 22:] = 0.0
    return translation + PELVIS, rotations


def fields():
    pelvis, rotations = truth()
    local = matrices(rotations[:, :22]).astype(np.float32)
    return {
        "posed_joints": places(rotations, pelvis, STRANGER).astype(np.float32),
        "local_rot_mats": local,
        "global_rot_mats": local,
        "foot_contacts": np.ones((FRAMES, 4)),
        "smooth_root_pos": pelvis,
        "root_positions": pelvis,
        "global_root_heading": np.ones((FRAMES, 2)),
    }


def written(path, content):
    np.savez(path, **content)
    return path


def test_joints_and_rotations_are_the_files(tmp_path):
    path = written(tmp_path / "a.npz", fields())
    sequence = quiet(path)
    pelvis, rotations = truth()
    expected = places(rotations, pelvis, STRANGER)
    expected = np.stack([expected[..., 0], -expected[..., 2], expected[..., 1]], axis=-1)
    own = sequence.bodies[0].joints(sequence.motion)[:, :22]
    assert np.abs(own - expected).max() < ROUNDING
    assert np.abs(sequence.motion.rotations[:, 1:] - rotations[:, 1:]).max() < 1e-5
    assert sequence.motion.fps == 30.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motion = hp.Motion.load(path)
    places_of_pelvis = hp.Body.default().joints(motion)[:, 0]
    assert np.abs(places_of_pelvis - expected[:, 0]).max() < ROUNDING


def joints(count):
    def change(content):
        content["posed_joints"] = np.zeros((FRAMES, count, 3))
        content["local_rot_mats"] = np.zeros((FRAMES, count, 3, 3))

    return change


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without("posed_joints"), "no known motion format"),
        (joints(77), "SOMA.*BVH"),
        (joints(30), "SOMA.*BVH"),
        (joints(34), "Unitree G1"),
        (joints(5), "'posed_joints'.*expected"),
        (changed("local_rot_mats", lambda a: a[:, :21]), "'local_rot_mats'.*expected"),
        (changed("local_rot_mats", lambda a: 2.0 * a), "no rotations"),
        (changed("local_rot_mats", lambda a: -a), "no rotations"),
        (changed("local_rot_mats", lambda a: a[::-1]), "disagree"),
        (changed("posed_joints", lambda a: a[:9]), "different length"),
        (spoilt("posed_joints", (2, 1, 1), np.nan), "'posed_joints'.*NaN.*frame 2"),
    ],
)
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "a.npz", content), message)
