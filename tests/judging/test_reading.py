"""The body and the scene in which clips are judged."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.cli.judge import Options
from halfphysics.judging.reading import Files
from support.files.model_files import fields, write_npz
from support.made_clips import walk


def test_without_a_model_the_body_is_the_files_own_or_the_default():
    own = hp.Body.default(stature=1.6)
    assert Files().body(own, walk()) is own
    assert Files().body(None, walk()).stature == hp.Body.default().stature


def test_a_model_gets_the_betas_of_its_motions(tmp_path):
    path = write_npz(tmp_path / "SMPLX_NEUTRAL.npz", fields())
    walks = walk()
    for betas in (np.zeros(4), np.array([2.0, -1.0, 0.5, 0.0])):
        motion = hp.Motion(walks.translation, walks.rotations, walks.fps, betas=betas)
        found = Files(body_model=path).body(hp.Body.default(), motion)
        asked = hp.Body.load(path, betas)
        assert np.array_equal(found.rest_joints, asked.rest_joints)


def test_a_scene_file_gets_a_floor(tmp_path):
    path = tmp_path / "room.yaml"
    path.write_text("statics:\n  wall: {shape: box, size: [0.1, 2, 2], position: [1, 0, 1]}\n")
    assert Files().scene() is None
    scene = Files(scene_file=path).scene()
    assert {"wall"} < set(scene.statics)
    assert Options().scene() is None


def test_equal_readings_share_a_scene(tmp_path):
    assert hash(Files(scene_file=tmp_path)) == hash(Files(scene_file=tmp_path))
    assert hash(Options()) == hash(Options())
