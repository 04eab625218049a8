"""TRUMANS: one clip in a pickle, and the release as a folder of arrays; y-up."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base.axes import axes_of
from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.files.layouts import movement, quiet
from support.files.trumans_files import CLIPS, release
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    hostile_is_refused,
    put,
    refused,
    uneven,
    usual,
    without,
)

ROUNDING = 1e-12
SINGLE = 1e-6

# -- one clip ----------------------------------------------------------------------------------


def fields(frames: int = 12) -> dict:
    translation, r = movement(frames, up="y")
    return {
        "global_orient": r[:, 0],
        "body_pose": r[:, list(BODY_JOINTS)].reshape(frames, 63),
        "left_hand_pose": r[:, list(LEFT_HAND_JOINTS)].reshape(frames, 45),
        "right_hand_pose": r[:, list(RIGHT_HAND_JOINTS)].reshape(frames, 45),
        "jaw_pose": r[:, 22],
        "leye_pose": r[:, 23],
        "reye_pose": r[:, 24],
        "expression": np.ones((frames, 10)),
        "transl": translation,
        "betas": np.zeros(0),
    }


def pickled(path, content):
    path.write_bytes(pickle.dumps(content))
    return path


def as_asked(body, hands=True):
    translation, rotations = movement(up="y")
    if not hands:
        rotations[:, 22:] = 0.0
    return body.vertices(hp.Motion(translation, rotations, 30.0)) @ axes_of("y").T


def test_a_clip_is_read_and_written(tmp_path):
    path = pickled(tmp_path / "a.pkl", fields())
    with pytest.warns(hp.HalfPhysicsWarning, match="zero fingers.*taken as flat.*hands='flat'"):
        unsaid = hp.Motion.load(path)
    motion = hp.Motion.load(path, hands="flat")
    assert np.array_equal(unsaid.rotations, motion.rotations)
    assert (motion.fps, motion.model, motion.betas) == (30.0, "smplx", None)
    body = hp.Body.default()
    assert np.abs(body.vertices(motion) - as_asked(body)).max() < ROUNDING
    motion.save(tmp_path / "b.pkl")
    again = pickle.loads((tmp_path / "b.pkl").read_bytes())
    assert again.keys() == fields().keys()
    for key, value in fields().items():
        assert np.abs(again[key] - value).max(initial=0.0) < ROUNDING, key


@pytest.mark.parametrize("shape", [(1, 10), (10,), (1, 12), (12,)])
def test_one_expression_is_that_of_every_frame(tmp_path, shape):
    """Of as many numbers as there are frames, too."""
    expression = np.arange(float(np.prod(shape)))
    content = {**fields(), "expression": expression.reshape(shape)}
    motion = hp.Motion.load(pickled(tmp_path / "a.pkl", content), hands="flat", frames=(2, 10))
    motion.resample(60.0).save(tmp_path / "b.pkl")
    again = pickle.loads((tmp_path / "b.pkl").read_bytes())["expression"]
    assert np.array_equal(again, np.tile(expression, (15, 1)))


def test_expressions_of_other_frames_are_not_kept(tmp_path):
    path = pickled(tmp_path / "a.pkl", {**fields(), "expression": np.ones((11, 10))})
    with pytest.warns(hp.HalfPhysicsWarning, match="'expression': found 11 rows for 12.*not kept"):
        motion = hp.Motion.load(path, hands="flat", frames=(2, 8))
    motion.resample(60.0).save(tmp_path / "b.pkl")
    assert "expression" not in pickle.loads((tmp_path / "b.pkl").read_bytes())


def test_a_clip_without_fingers_needs_nothing_said(tmp_path):
    content = fields()
    for key in ("left_hand_pose", "right_hand_pose"):
        content[key] = np.zeros((12, 45))
    assert not hp.Motion.load(pickled(tmp_path / "a.pkl", content)).rotations[:, 25:].any()


WRONG = [
    *usual("transl"),
    *usual("body_pose"),
    *map(uneven, ("transl", "global_orient", "body_pose", "expression")),
    ("no root", without("global_orient"), "'global_orient' is missing"),
    ("betas per frame", put("betas", np.random.default_rng(0).normal(size=(12, 10))), "changes"),
    ("betas of another length", put("betas", np.ones((5, 10))), "betas"),
    ("hands of two people", put("left_hand_pose", np.zeros((12, 2, 45))), "'left_hand_pose'"),
    ("gender unknown", put("gender", "robot"), "gender"),
    ("fps negative", put("fps", -30), "'fps'"),
    ("expression short", changed("expression", lambda a: a * np.nan), "'expression'.*NaN"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_clips(tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(pickled(tmp_path / "bad.pkl", content), message, hands="flat")


def test_hostile_and_broken_clips(tmp_path):
    hostile_is_refused(tmp_path / "evil.pkl", fields(), "betas", hands="flat")
    broken_bytes_are_refused(pickled(tmp_path / "a.pkl", fields()), hands="flat")


# -- the release -------------------------------------------------------------------------------


def test_clips_are_cut_by_their_names(tmp_path):
    folder = release(tmp_path / "TRUMANS", objects=False)
    clips = list(hp.clips(folder))
    assert [clip.name for clip in clips] == list(CLIPS)
    body = hp.Body.default()
    motion = clips[0].motion()
    assert len(motion) == 12
    assert np.abs(body.vertices(motion) - as_asked(body, hands=False)).max() < SINGLE
    assert abs(clips[3].motion().translation[0, 0] - movement(2, up="y")[0][0, 0] - 3) < SINGLE
    part = hp.Motion.load(folder, clip="walk@1", frames=(3, 8))
    assert np.array_equal(part.translation, motion.translation[3:8])
    # Found in a library, too.
    assert [clip.name for clip in hp.clips(tmp_path)] == list(CLIPS)


def test_objects_and_scene(tmp_path):
    import trimesh

    folder = release(tmp_path / "TRUMANS")
    assets = tmp_path / "meshes"
    (assets / "Object_mesh").mkdir(parents=True)
    (assets / "Scene_mesh").mkdir()
    cup = trimesh.creation.box((0.1, 0.2, 0.3))
    cup.apply_translation((0.02, 0.1, 0.0))
    cup.export(assets / "Object_mesh" / "cup.obj")
    trimesh.creation.box((4, 0.1, 4)).export(assets / "Scene_mesh" / "hall.obj")
    refused(folder, "mesh of the scene 'hall'.*Looked for.*assets=", clip="walk@1")
    with pytest.warns(hp.HalfPhysicsWarning, match="what 'cup' weighs: 2.4 kg"):
        sequence = hp.load_sequence(folder, assets, clip="walk@1")
    assert list(sequence.scene.statics) == ["hall"]
    thing, track = sequence.scene.objects["cup"], sequence.recorded["cup"]
    # The data set's own rule for its vertices, then turned to z-up.
    matrices = np.load(folder / "object_mat.npy")[:12, 3].astype(float)
    for frame in (0, 5, 11):
        asked = cup.vertices @ matrices[frame, :3, :3] + matrices[frame, :3, 3]
        placed = rot.rotate(track.quaternion[frame], cup.vertices) + track.position[frame]
        assert np.abs(placed - asked @ axes_of("y").T).max() < SINGLE
    assert np.array_equal(thing.position, track.position[0])
    replayed = hp.load_sequence(folder, [assets], clip="walk@1", objects="replayed")
    assert np.array_equal(replayed.scene.objects["cup"].positions, track.position)
    assert not hp.load_sequence(folder, assets, clip="sit@2").recorded  # without the object
    for kind in ("Object_mesh", "Scene_mesh"):  # beside the arrays they are found without an option
        (assets / kind).rename(folder / kind)
    inside = hp.load_sequence(folder, clip="walk@1", objects="replayed")
    assert list(inside.scene.statics) == ["hall"]
    assert np.array_equal(inside.scene.objects["cup"].positions, track.position)


@pytest.mark.parametrize("up", [None, "z", "-y"])
def test_the_room_follows_the_axis_that_is_said_to_be_up(tmp_path, up):
    import trimesh

    folder = release(tmp_path / "TRUMANS")
    for kind, name, size in (("Object", "cup", (0.1, 0.2, 0.3)), ("Scene", "hall", (4, 0.1, 3))):
        (folder / f"{kind}_mesh").mkdir()
        trimesh.creation.box(size).export(folder / f"{kind}_mesh" / f"{name}.obj")
    sequence = quiet(folder, clip="walk@1", up=up)
    hall = sequence.scene.statics["hall"]
    placed = rot.rotate(hall.quaternion, hall.shape.vertices) + hall.position
    extent = np.abs(np.array([2.0, 0.05, 1.5]) @ axes_of(up or "y").T)
    assert np.abs(np.abs(placed).max(axis=0) - extent).max() < SINGLE
    asked = np.load(folder / "object_mat.npy")[:12, 3, :3, 3].astype(float)
    cup = sequence.recorded["cup"].position
    assert np.abs(cup - asked @ axes_of(up or "y").T).max() < SINGLE


def spoil_array(folder, key, how):
    np.save(folder / f"{key}.npy", how(np.load(folder / f"{key}.npy")))


def nan_in(array):
    array[2] = np.nan
    return array


BROKEN = {
    "no names": (lambda f: (f / "seg_name.npy").unlink(), "seg_name.npy is missing"),
    "no orient": (lambda f: (f / "human_orient.npy").unlink(), "human_orient.npy is missing"),
    "names of numbers": (lambda f: spoil_array(f, "seg_name", lambda a: np.arange(51)), "text"),
    "names in two axes": (lambda f: spoil_array(f, "seg_name", lambda a: a[:, None]), "text"),
    "pose narrow": (lambda f: spoil_array(f, "human_pose", lambda a: a[:, :60]), "'human_pose'"),
    "pose short": (lambda f: spoil_array(f, "human_pose", lambda a: a[:5]), "different length"),
    "transl short": (lambda f: spoil_array(f, "human_transl", lambda a: a[:5]), "length"),
    "NaN": (lambda f: spoil_array(f, "human_transl", nan_in), "'human_transl'.*NaN"),
    "orient of text": (lambda f: spoil_array(f, "human_orient", lambda a: a.astype(str)), "'huma"),
    "flags too large": (lambda f: spoil_array(f, "object_flag", lambda a: a + 6), "object_flag"),
    "matrices narrow": (
        lambda f: spoil_array(f, "object_mat", lambda a: a[:, :, :3]),
        "'object_mat'",
    ),
    "no object names": (lambda f: (f / "object_list.npy").unlink(), "'object_list' is missing"),
    "scene unknown": (lambda f: spoil_array(f, "scene_flag", lambda a: a + 5), "scene_list"),
    "truncated": (lambda f: (f / "human_pose.npy").write_bytes(b"\x93NUMPY"), "damaged"),
    "cut": (
        lambda f: (f / "human_pose.npy").write_bytes((f / "human_pose.npy").read_bytes()[:500]),
        "truncated",
    ),
    "no array": (lambda f: (f / "human_pose.npy").write_bytes(b"hello"), "damaged"),
    "objects in it": (
        lambda f: np.save(f / "human_pose.npy", np.array([None] * 51), allow_pickle=True),
        "Python objects",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_releases(tmp_path, name):
    folder = release(tmp_path / "TRUMANS")
    how, message = BROKEN[name]
    how(folder)
    from unittest import mock

    import trimesh

    mesh = tmp_path / "box.obj"
    trimesh.creation.box((1, 1, 1)).export(mesh)
    with mock.patch("halfphysics.formats.datasets.trumans_release.find", return_value=mesh):
        refused(folder, message, clip="walk@1")


def test_wrong_clips_of_a_release(tmp_path):
    folder = release(tmp_path / "TRUMANS", objects=False)
    refused(folder, "holds several clips: walk@1, sit@2.*Say which with clip=")
    refused(folder, "has no 'walk'.*did you mean", clip="walk")
    refused(folder, "'walk@1' has 12 frames", clip="walk@1", frames=(5, 5))
