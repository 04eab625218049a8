"""MDM's SMPL parameters: rows of matrices, the place of the pelvis, the licensed pelvis at rest."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.formats.positions.mdm_smpl import matrices_of_rows
from support.files.layouts import movement, quiet
from support.files.position_files import matrices, offsets, places, rows
from support.files.wrong_files import changed, put, refused, spoilt, without

ROUNDING = 1e-5  # metres, of single precision
REST = np.asarray(hp.Body.default().rest_joints)
FRAMES = 20
PELVIS = np.array([0.0, 0.9, 0.0])


def truth():
    translation, rotations = movement(FRAMES, up="y")
    rotations = np.array(rotations)
    rotations[:, 22:] = 0.0
    return translation + PELVIS, rotations


def fields():
    pelvis, rotations = truth()
    hands = np.pad(rotations[:, :22], [(0, 0), (0, 2), (0, 0)])
    return {
        "motion": np.zeros((25, 6, FRAMES)),
        "thetas": np.moveaxis(rows(hands), 0, -1).astype(np.float32),
        "root_translation": pelvis.T.astype(np.float32),
        "faces": np.zeros((4, 3), dtype=np.int64),
        "vertices": np.zeros((4, 3, FRAMES), dtype=np.float32),
        "text": "walk",
        "length": FRAMES,
    }


def written(path, content):
    np.save(path, content, allow_pickle=True)
    return path


def test_joints_are_the_truth(tmp_path):
    path = written(tmp_path / "sample00_rep00_smpl_params.npy", fields())
    motion = quiet(path).motion
    pelvis, rotations = truth()
    expected = places(rotations, pelvis, offsets(REST))
    expected = np.stack([expected[..., 0], -expected[..., 2], expected[..., 1]], axis=-1)
    assert np.abs(hp.Body.default().joints(motion) - expected).max() < ROUNDING
    assert (motion.fps, motion.model, motion.origin.fields["text"]) == (20.0, "smpl", "walk")
    assert len(quiet(path, frames=(3, 9)).motion) == 6


def test_the_pelvis_of_another_body_is_where_it_was(tmp_path):
    motion = hp.scenarios.load("walk_into_wall").motion[:20]
    tall = hp.Body.default(stature=1.9)
    motion.save(tmp_path / "a.npy", format="mdm-smpl", body=tall)
    other = quiet(tmp_path / "a.npy").motion
    apart = hp.Body.default().joints(other)[:, 0] - tall.joints(motion)[:, 0]
    assert np.abs(apart).max() < ROUNDING


def test_rows_that_are_not_quite_orthogonal():
    rotations = truth()[1][:, :22]
    noisy = 1.3 * rows(rotations)
    assert np.abs(matrices_of_rows(noisy) - matrices(rotations)).max() < 1e-12


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (without("root_translation"), "no known motion format"),
        (changed("thetas", lambda a: a[:22]), "'thetas'.*expected"),
        (changed("thetas", lambda a: np.moveaxis(a, 2, 0)), "'thetas'.*expected"),
        (changed("thetas", lambda a: 0.0 * a), "no rotations of six numbers"),
        (changed("thetas", lambda a: a[..., :9]), "different length"),
        (changed("root_translation", lambda a: a.T), "'root_translation'.*expected"),
        (spoilt("root_translation", (1, 2), np.inf), "'root_translation'.*infinite"),
        (put("thetas", None), "'thetas'.*expected"),
    ],
)
def test_wrong_files(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "a.npy", content), message)
