"""InterCap: a person and an object before cameras, y down; hands as components."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from support.files import recorded_sets as sets
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import broken_bytes_are_refused, hostile_is_refused, refused, usual

SOMEONE = sets.person(12, tuple(range(22)))
HANDS = np.random.default_rng(1).normal(0, 0.1, (sets.FRAMES, 24))


def written(tmp_path, content=None):
    """At its place: subject 03, a woman, with object 07, a chair."""
    folder = tmp_path / "RES" / "03" / "07" / "Seg_0"
    sets.dump(
        folder / "res.pkl", sets.intercap_fields(SOMEONE, HANDS) if content is None else content
    )
    places, turns, *_ = sets.thing(sets.Y_DOWN)
    made = sets.mesh(folder / "Mesh" / "00000_second_obj.ply")
    matrix = hp.base.rotations.rotvec_to_matrix(turns[0])
    made.vertices = sets.placed(made.vertices, places[0], matrix)
    made.export(folder / "Mesh" / "00000_second_obj.ply")
    return folder


@pytest.mark.parametrize("joined", [False, True])
def test_y_down_with_the_object_of_the_first_frame(tmp_path, joined):
    content = sets.intercap_fields(SOMEONE, HANDS)
    if joined:
        keys = ("global_orient", "body_pose", "left_hand_pose", "right_hand_pose")
        poses = np.concatenate([content.pop(key) for key in keys], axis=1)
        content |= {"poses": poses, "trans": content.pop("transl")}
    folder = written(tmp_path, content)
    for path in (folder, folder / "res.pkl"):
        sequence = sets.load(path)
        motion = sequence.motion
        assert (motion.fps, motion.model, motion.gender) == (30.0, "smplx", "female")
        assert motion.betas.tolist() == sets.BETAS.tolist()
        assert sets.off(motion, SOMEONE) < sets.DOUBLE
    *_, places, matrices = sets.thing(sets.Y_DOWN)
    vertices = sets.mesh(tmp_path / "own.obj").vertices
    for frame in (0, sets.FRAMES - 1):
        asked = sets.placed(vertices, places[frame], matrices[frame])
        assert sets.mesh_off(sequence, "chair", asked, frame) < sets.SINGLE


def test_hands_by_the_model(tmp_path):
    content = model_fields("smplx")
    model = write_npz(tmp_path / "SMPLX_FEMALE.npz", content)
    full = SOMEONE[1].copy()
    for joints, side, part in ((sets.LEFT, "l", HANDS[:, :12]), (sets.RIGHT, "r", HANDS[:, 12:])):
        bent = content[f"hands_mean{side}"] + part @ content[f"hands_components{side}"][:12]
        full[:, joints] = bent.reshape(-1, 15, 3)
    motion = hp.Motion.load(written(tmp_path), model=model)
    assert sets.off(motion, (SOMEONE[0], full)) < sets.DOUBLE
    assert [clip.format for clip in hp.clips(tmp_path / "RES")] == ["intercap"]
    with pytest.warns(hp.HalfPhysicsWarning, match="12 principal components.*fingers stay flat"):
        hp.Motion.load(written(tmp_path))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [c[1:] for key in ("global_orient", "transl", "left_hand_pose") for c in usual(key)[1:]],
)
def test_wrong_people(tmp_path, spoil, message):
    content = sets.intercap_fields(SOMEONE, HANDS)
    spoil(content)
    refused(written(tmp_path, content), message)


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in usual("ob_pose")])
def test_wrong_objects(tmp_path, spoil, message):
    content = sets.intercap_fields(SOMEONE, HANDS)
    spoil(content)
    refused(written(tmp_path, content) / "res.pkl", message)


def test_files_that_are_missing_hostile_or_broken(tmp_path):
    folder = written(tmp_path)
    (folder / "Mesh" / "00000_second_obj.ply").unlink()
    refused(folder, "the mesh of 'chair'.*objects/chair/chair.obj")
    hostile_is_refused(folder / "a.pkl", sets.intercap_fields(SOMEONE, HANDS), "betas")
    broken_bytes_are_refused(folder / "res.pkl")
