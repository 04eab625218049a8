"""BEHAVE files: a person and an object in the frame of a camera, y down."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import SMPLH_JOINTS
from support.files.layouts import movement, quiet
from support.files.linear_blend import lbs
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import (
    Boom,
    broken_bytes_are_refused,
    changed,
    put,
    refused,
    usual,
    without,
)

#: As the data set has it: tests of the floor that is added are in test_ground.py.
load_sequence = partial(hp.load_sequence, ground=False)

FRAMES = 12
ROUNDING = 1e-12
SINGLE = 1e-6  # metres: meshes in files are in single precision
#: World from the camera's x right, y down, z ahead: up is -y, and what is ahead of it is +y.
CAMERA = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
#: The scan lies anywhere in its file.
MIDDLE = np.array([0.7, -0.4, 0.2])


def world() -> tuple[np.ndarray, np.ndarray]:
    """Translation and rotations, all joints of SMPL-H bent, upright along the world's z."""
    translation, r = movement(FRAMES, up="z")
    r[:, [22, 23, 24]] = 0.0
    return translation, r


def fields() -> dict:
    """The person's file."""
    translation, r = world()
    r[:, 0] = rot.log(rot.multiply(rot.from_matrix(CAMERA.T), rot.exp(r[:, 0])))
    return {
        "poses": r[:, list(SMPLH_JOINTS)].reshape(FRAMES, 156),
        "betas": np.tile(np.linspace(1.0, -1.0, 10), (FRAMES, 1)),
        "trans": translation @ CAMERA,
        "frame_times": np.array([f"t{3 + k / 30:08.3f}" for k in range(FRAMES)]),
    }


def thing() -> dict:
    """The object's file."""
    t = np.linspace(0.0, 1.0, FRAMES)[:, None]
    return {
        "angles": np.array([0.3, -0.5, 1.0]) + t * np.array([0.2, 0.4, -0.1]),
        "trans": np.array([0.2, 0.5, 2.2]) + t * np.array([0.1, -0.2, 0.05]),
        "frame_times": fields()["frame_times"],
    }


def written(root, content=None, other=None, info=True):
    """The sequence at its place in the data set's folder."""
    folder = root / "behave" / "sequences" / "Date01_Sub01_boxlarge_hand"
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "smpl_fit_all.npz", **(fields() if content is None else content))
    np.savez(folder / "object_fit_all.npz", **(thing() if other is None else other))
    if info:
        (folder / "info.json").write_text(json.dumps({"gender": "female", "cat": "boxlarge"}))
    return folder


@pytest.fixture
def data_set(tmp_path):
    meshes = tmp_path / "behave" / "objects" / "boxlarge"
    meshes.mkdir(parents=True)
    # Most vertices are at its base: their mean is not its middle.
    cone = trimesh.creation.cone(0.2, 0.4)
    cone.apply_translation(MIDDLE)
    cone.export(meshes / "boxlarge_f1000.ply")
    return written(tmp_path)


def test_y_down_30_fps_smplh_flat_hands(data_set):
    for path in (data_set, data_set / "smpl_fit_all.npz"):
        motion = hp.Motion.load(path)
        assert (motion.fps, motion.model, motion.gender) == (30.0, "smplh", "female")
        assert np.allclose(motion.betas, np.linspace(1.0, -1.0, 10))
        body = hp.Body.default()
        pelvis = body.rest_joints[0]
        translation, r = world()
        # In the camera's frame the pelvis is at J0 + trans.
        asked = hp.Motion(translation + CAMERA @ pelvis - pelvis, r, 30.0)
        assert np.abs(body.vertices(motion) - body.vertices(asked)).max() < ROUNDING
        assert (rot.to_matrix(rot.exp(motion.rotations[:, 0]))[:, 2, 1] > 0.5).all()


def test_it_is_read_as_behave_and_not_as_amass(data_set):
    clips = list(hp.clips(data_set.parents[1]))
    assert [clip.format for clip in clips] == ["behave"]
    assert hp.Motion.load(data_set / "smpl_fit_all.npz").origin.format == "behave"


def test_the_mesh_is_about_the_mean_of_its_vertices(data_set):
    sequence = quiet(data_set, ground=False)
    item, track = sequence.scene.objects["boxlarge"], sequence.recorded["boxlarge"]
    raw = trimesh.load(data_set.parents[1] / "objects/boxlarge/boxlarge_f1000.ply", process=False)
    assert np.abs(raw.vertices.mean(axis=0) - MIDDLE).max() > 0.005
    own = np.asarray(raw.vertices) - raw.vertices.mean(axis=0)
    params = thing()
    for frame in range(FRAMES):
        turn = rot.rotvec_to_matrix(params["angles"][frame])
        asked = (own @ turn.T + params["trans"][frame]) @ CAMERA.T
        placed = rot.rotate(track.quaternion[frame], item.visual.vertices) + track.position[frame]
        away = np.linalg.norm(placed[:, None] - asked[None], axis=-1)
        assert max(away.min(axis=0).max(), away.min(axis=1).max()) < SINGLE
    assert np.array_equal(item.position, track.position[0])


def test_the_users_model_gives_the_body(data_set, tmp_path):
    model = write_npz(tmp_path / "models" / "smplh" / "SMPLH_FEMALE.npz", model_fields("smplh"))
    for option in (model, tmp_path / "models"):
        sequence = quiet(data_set, model=option, ground=False)
        content, r = model_fields("smplh"), fields()
        poses = r["poses"].reshape(FRAMES, 52, 3)
        for frame in (0, FRAMES - 1):
            asked = lbs("smplh", content, r["betas"][0], poses[frame]) + r["trans"][frame]
            found = sequence.body.vertices(sequence.motion, frames=frame)
            assert np.abs(found - asked @ CAMERA.T).max() < 1e-9


def test_a_turned_copy_is_read_with_y_up(data_set, tmp_path):
    content, turn = fields(), np.diag([1.0, -1.0, -1.0])
    content["poses"][:, :3] = rot.log(
        rot.multiply(rot.from_matrix(turn), rot.exp(content["poses"][:, :3]))
    )
    content["trans"] = content["trans"] @ turn
    with pytest.warns(hp.HalfPhysicsWarning, match="stands along y: read with y up"):
        motion = hp.Motion.load(written(tmp_path, content))
    assert (rot.to_matrix(rot.exp(motion.rotations[:, 0]))[:, 2, 1] > 0.5).all()


def test_what_is_not_said_is_taken_from_names(data_set):
    (data_set / "info.json").unlink()
    with pytest.warns(hp.HalfPhysicsWarning, match="does not say a gender"):
        assert hp.Motion.load(data_set).gender == "neutral"
    assert list(quiet(data_set).scene.objects) == ["boxlarge"]


def test_gaps_and_shapes_that_vary_are_said(tmp_path):
    content = fields()
    content["frame_times"] = np.array([f"t{k / 30 + (k > 5):08.3f}" for k in range(FRAMES)])
    with pytest.warns(hp.HalfPhysicsWarning, match=r"1 gaps: between frames 5 and 6 are 1.03 s"):
        hp.Motion.load(written(tmp_path, content))
    content = fields()
    content["betas"][3, 0] += 0.5
    with pytest.warns(hp.HalfPhysicsWarning, match=r"'betas'.*by up to 0.5; the median"):
        assert hp.Motion.load(written(tmp_path, content)).betas[0] == 1.0


def test_a_body_of_unknown_size_is_the_default(data_set):
    with pytest.warns(hp.HalfPhysicsWarning, match="in metres.*Body.default.. is taken"):
        assert load_sequence(data_set, objects="replayed").body is None


def test_it_is_read_only(data_set, tmp_path):
    motion = hp.Motion.load(data_set)
    with pytest.raises(hp.HalfPhysicsError, match="'behave' can only be read"):
        motion.save(tmp_path / "again.npz", format="behave")


WRONG = [
    *usual("poses"),
    *usual("trans"),
    ("times of nothing", put("frame_times", np.array(["t0"] * 5)), "different length"),
    ("times of text", put("frame_times", np.array(["now"] * FRAMES)), "found 'now' in frame 0"),
    ("betas wrong", changed("betas", lambda a: a[:5]), "betas"),
    ("too fast", changed("trans", lambda a: a * 1e4), "m/s"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_people(data_set, tmp_path, spoil, message):
    content = fields()
    spoil(content)
    path = written(tmp_path, content) / "smpl_fit_all.npz"
    if "frame_times" not in content or not {"poses", "trans"} <= content.keys():
        message = "no known motion format|'trans' is missing"  # its keys say what it is
    refused(path, message)


OTHERS = [
    *usual("angles"),
    ("no times", without("frame_times"), "'frame_times' is missing"),
    ("other times", put("frame_times", np.array([f"t{k}" for k in range(12)])), "other times"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in OTHERS], ids=[c[0] for c in OTHERS])
def test_wrong_objects(data_set, tmp_path, spoil, message):
    content = thing()
    spoil(content)
    written(tmp_path, other=content)
    with pytest.raises(hp.HalfPhysicsError, match=f"(?s)object_fit_all.npz.*({message})"):
        quiet(data_set)


def test_files_that_are_not_there_or_another(data_set):
    refused(data_set / "object_fit_all.npz", "the object of a BEHAVE sequence.*smpl_fit_all.npz")
    mesh = data_set.parents[1] / "objects/boxlarge/boxlarge_f1000.ply"
    mesh.rename(mesh.with_name("other.ply"))
    refused(data_set, "the mesh of 'boxlarge'.*boxlarge_f1000.ply.*assets=")
    (data_set / "info.json").write_text("{")
    refused(data_set, "cannot be read|info.json")
    (data_set / "info.json").unlink()
    plain = data_set.rename(data_set.with_name("plain"))
    refused(plain, "which object it is.*'cat'.*DATE_SUBJECT_OBJECT", gender="male")
    (plain / "object_fit_all.npz").unlink()
    refused(plain, "its object is in object_fit_all.npz", gender="male")


def test_hostile_and_broken_files(data_set, tmp_path):
    mark = tmp_path / "was_run"
    path = written(tmp_path, {**fields(), "betas": np.array(Boom(mark), dtype=object)})
    refused(path / "smpl_fit_all.npz", "'betas'.*unsafe or unknown content")
    assert not mark.exists()
    broken_bytes_are_refused(written(tmp_path) / "smpl_fit_all.npz")
