"""OMOMO files: many clips in one joblib dump, each with its object."""

from __future__ import annotations

import pickle
import re
import warnings
from functools import partial

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.base import stored_objects as stored
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import BODY_JOINTS, PARENTS
from support.bones import elsewhere, world_joints
from support.files.dumps import Wrapper, joblib_dump
from support.files.layouts import movement
from support.files.model_files import fields as model_fields
from support.files.model_files import write_npz
from support.files.wrong_files import (
    broken_bytes_are_refused,
    changed,
    hostile_is_refused,
    put,
    refused,
    spoilt,
    usual,
    without,
)

#: As the data set has it: tests of the floor that is added are in test_ground.py.
load_sequence = partial(hp.load_sequence, ground=False)

ROUNDING = 1e-12
SINGLE = 1e-6
# Metres, of joints that chains of rotations place.
FAR = 1e-9
CLIP = "sub3_largebox_003"
TWO = "sub4_mop_011"
#: The joints of `rest_offsets`: 22 of the body and the middle knuckles.
JOINTS = [*range(22), 28, 43]


#: Every sequence says that its body has the recorded bones.
told = pytest.mark.filterwarnings("ignore:.*recorded bones")


def fields(frames: int = 12, name: str = CLIP, seed: int = 0) -> dict:
    """A clip as the file has it."""
    translation, r = movement(frames, seed)
    t = np.linspace(0.0, 1.0, frames)[:, None]
    clip = {
        "seq_name": name,
        "betas": np.linspace(1.0, -1.0, 16)[None],
        "gender": "male",
        "trans": translation,
        "root_orient": r[:, 0],
        "pose_body": r[:, list(BODY_JOINTS)].reshape(frames, 63),
        "rest_offsets": elsewhere()[JOINTS],
        "trans2joint": -elsewhere()[0],
        "obj_trans": (t * [1.0, 0.5, 0.2] + 1.0)[:, :, None],
        "obj_rot": rot.to_matrix(rot.exp(t * [0.3, 1.0, -0.2])),
        "obj_scale": np.full(frames, 0.25),
        "obj_com_pos": t * [1.0, 0.5, 0.2] + 1.0,
    }
    if name == TWO:
        clip["obj_bottom_trans"] = clip["obj_trans"] - 0.8
        clip["obj_bottom_rot"] = rot.to_matrix(rot.exp(t * [0.0, 0.4, 0.9]))
        clip["obj_bottom_scale"] = np.full(frames, 0.5)
    return clip


def written(path, *clips):
    path.write_bytes(pickle.dumps(dict(enumerate(clips))))
    return path


@pytest.fixture
def assets(tmp_path):
    """Meshes as the data set has them: not centred on their origin."""
    folder = tmp_path / "data" / "captured_objects"
    folder.mkdir(parents=True)
    for index, name in enumerate(("largebox", "mop", "mop_top", "mop_bottom")):
        kind, _, part = name.partition("_")
        box = trimesh.creation.box((1.0, 2.0, 0.5 + index))
        box.apply_translation((0.3, 0.1, index))
        box.export(folder / f"{kind}_cleaned_simplified{'_' * bool(part)}{part}.obj")
    return folder.parent


def asked(body, frames: int = 12, seed: int = 0):
    """The vertices of the clip: no fingers, no face."""
    translation, rotations = movement(frames, seed)
    rotations[:, 22:] = 0.0
    return body.vertices(hp.Motion(translation, rotations, 30.0))


def test_clips_of_one_file(tmp_path):
    path = written(tmp_path / "train.p", fields(), fields(20, "sub3_largebox_004", 5), fields(7))
    clips = list(hp.clips(tmp_path))
    assert [clip.name for clip in clips] == [CLIP, "sub3_largebox_004", f"{CLIP}#2"]
    motion = clips[0].motion()
    assert (motion.fps, motion.model, motion.gender, len(motion.betas)) == (
        30.0,
        "smplx",
        "male",
        16,
    )
    body = hp.Body.default()
    assert np.abs(body.vertices(motion) - asked(body)).max() < ROUNDING
    other = hp.Motion.load(path, clip="sub3_largebox_004")
    assert np.abs(body.vertices(other) - asked(body, 20, 5)).max() < ROUNDING
    part = hp.Motion.load(path, clip="sub3_largebox_004", frames=(3, 8))
    assert np.array_equal(part.translation, other.translation[3:8])
    assert len(clips[2].motion()) == 7
    refused(path, f"holds several clips: {CLIP}, sub3.*clip=")
    refused(path, "did you mean", clip="sub3_largebox_005")
    with pytest.raises(InputError, match="clip: found '', expected the name of a clip"):
        hp.Motion.load(path, clip="")


def test_a_file_is_read_once_for_all_its_clips(tmp_path, monkeypatch):
    path = written(tmp_path / "a.p", *(fields(name=f"sub1_largebox_{i:03}") for i in range(5)))
    times, plain = [], stored.read
    monkeypatch.setattr(stored, "read", lambda path: times.append(path) or plain(path))
    assert [len(clip.motion()) for clip in hp.clips(path)] == [12] * 5
    assert times == [path]
    # A file given by its path is read anew: it may have changed.
    assert len(hp.Motion.load(path, clip="sub1_largebox_003")) == 12
    assert times == [path] * 2


def test_a_joblib_dump(tmp_path):
    wrap = {
        k: Wrapper(v.astype(np.float32)) if isinstance(v, np.ndarray) else v
        for k, v in fields().items()
    }
    path = tmp_path / "train_diffusion_manip_seq_joints24.p"
    path.write_bytes(joblib_dump({0: wrap}))
    body = hp.Body.default()
    assert np.abs(body.vertices(hp.Motion.load(path)) - asked(body)).max() < SINGLE


def test_bodies_by_joint_are_read_too(tmp_path):
    content = fields()
    content["pose_body"] = content["pose_body"].reshape(12, 21, 3)
    motion = hp.Motion.load(written(tmp_path / "a.p", content))
    body = hp.Body.default()
    assert np.abs(body.vertices(motion) - asked(body)).max() < ROUNDING


def placed(track, frame: int, vertices):
    return rot.rotate(track.quaternion[frame], vertices) + track.position[frame]


@told
@pytest.mark.parametrize("name", [CLIP, TWO])
def test_objects(tmp_path, assets, name):
    content = fields(name=name)
    path = written(tmp_path / "a.p", content)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sequence = load_sequence(path, assets)
    lines = ["recorded bones", "what 'largebox' weighs"]
    if name == TWO:
        lines = ["recorded bones", "what 'mop' weighs", "what 'mop_bottom' weighs", "holds the two"]
    (one,) = said  # all that was assumed, in one line
    assert [line for line in lines if line not in str(one.message)] == []
    assert "\n" not in str(one.message)
    kind = name.split("_")[1]
    parts = {kind: "obj_"} if name == CLIP else {kind: "obj_", f"{kind}_bottom": "obj_bottom_"}
    assert list(sequence.scene.objects) == list(sequence.recorded) == list(parts)
    for part, key in parts.items():
        ending = "" if name == CLIP else "_top" if key == "obj_" else "_bottom"
        mesh = f"captured_objects/{kind}_cleaned_simplified{ending}.obj"
        vertices = trimesh.load(assets / mesh).vertices
        scale = content[f"{key}scale"][0]
        track = sequence.recorded[part]
        for frame in (0, 5, 11):  # the data set's own rule
            rule = scale * (content[f"{key}rot"][frame] @ vertices.T)
            rule = rule.T + content[f"{key}trans"][frame, :, 0]
            assert np.abs(placed(track, frame, scale * vertices) - rule).max() < ROUNDING
        thing = sequence.scene.objects[part]
        size = np.ptp(thing.mesh()[0], axis=0)
        assert np.abs(size - scale * np.ptp(vertices, axis=0)).max() < SINGLE
        assert np.array_equal(thing.position, track.position[0])
    replayed = load_sequence(path, assets, objects="replayed")
    track = sequence.recorded[kind]
    assert np.array_equal(replayed.scene.objects[kind].positions, track.position)


def test_the_body_has_the_recorded_bones(tmp_path):
    """Every joint is where the file's own forward kinematics has it, in every frame."""
    content, bones = fields(), elsewhere()
    del content["obj_trans"], content["obj_rot"], content["obj_scale"], content["obj_com_pos"]
    path = written(tmp_path / "a.p", content)
    with pytest.warns(hp.HalfPhysicsWarning, match=r"recorded bones: stature 1\.65 m"):
        sequence = load_sequence(path)
    motion, body = sequence.motion, sequence.body
    places = world_joints(bones, motion)
    assert np.nanmax(np.abs(body.joints(motion) - places)) < FAR
    assert np.isfinite(places[:, JOINTS]).all()
    pelvis = content["trans"] - content["trans2joint"]
    assert np.abs(body.joints(motion)[:, 0] - pelvis).max() < ROUNDING
    # By the default body hands were elsewhere: what this is for.
    default = hp.Body.default()
    assert np.nanmax(np.abs(default.joints(motion) - places)[:, 20:22]) > 0.02
    with pytest.warns(hp.HalfPhysicsWarning, match="recorded bones"):
        part = load_sequence(path, frames=(3, 8), gender="male", model="smplx")
    assert np.array_equal(part.body.rest_vertices, body.rest_vertices)


NO_BONES = {
    "none": (without("rest_offsets"), "'rest_offsets' is missing"),
    "ones": (put("rest_offsets", np.ones((24, 3))), "bones: pelvis to .* found 1.73 m"),
    "NaN": (spoilt("rest_offsets", (4, 0), np.nan), "'rest_offsets'.*NaN"),
    "52 rows": (put("rest_offsets", np.ones((52, 3))), "'rest_offsets': found 52 rows"),
    "flat": (put("rest_offsets", np.ones(72)), "'rest_offsets'.*shape"),
    "text": (put("rest_offsets", "long"), "'rest_offsets'"),
    "a pelvis of text": (put("trans2joint", "low"), "'trans2joint'"),
    "a pelvis NaN": (put("trans2joint", np.full(3, np.nan)), "'trans2joint'.*NaN"),
    "a giant": (changed("rest_offsets", lambda a: 2.2 * a), "of a person of 3"),
}


@pytest.mark.parametrize("name", NO_BONES)
def test_without_bones_the_default_body_is_taken(tmp_path, name):
    spoil, message = NO_BONES[name]
    content = {k: v for k, v in fields().items() if not k.startswith("obj_")}
    spoil(content)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sequence = load_sequence(written(tmp_path / "a.p", content))
    (line,) = [str(w.message) for w in said]
    assert re.search(message, line), line
    assert "Body.default(), which is taken" in line
    assert sequence.body is None


def test_a_model_of_the_caller_is_left_alone(tmp_path):
    content = {k: v for k, v in fields().items() if not k.startswith("obj_")}
    model = write_npz(tmp_path / "SMPLX_MALE.npz", model_fields())
    sequence = load_sequence(written(tmp_path / "a.p", content), model=model)
    assert sequence.body is None  # and nothing is said


def test_bones_of_22_joints_and_no_pelvis(tmp_path):
    content = {k: v for k, v in fields().items() if not k.startswith("obj_")}
    content["rest_offsets"] = content["rest_offsets"][:22]
    del content["trans2joint"]
    with pytest.warns(hp.HalfPhysicsWarning, match="recorded bones"):
        body = load_sequence(written(tmp_path / "a.p", content)).body
    offsets = body.rest_joints[1:22] - body.rest_joints[PARENTS[1:22]]
    assert np.abs(offsets - elsewhere()[1:22]).max() < ROUNDING


@told
def test_a_size_that_varies_is_said(tmp_path, assets):
    content = fields()
    content["obj_scale"] = np.linspace(0.25, 0.252, 12)
    path = written(tmp_path / "a.p", content)
    load_sequence(path, assets, objects="replayed")  # without warnings of the size
    content["obj_scale"] = np.linspace(0.25, 0.26, 12)
    path = written(tmp_path / "b.p", content)
    with pytest.warns(hp.HalfPhysicsWarning, match="'obj_scale'.*size by 4 %; .* 0.25, is taken"):
        sequence = load_sequence(path, assets, objects="replayed")
    # The object's middle is where the data set has it, frame by frame.
    mesh = trimesh.load(assets / "captured_objects" / "largebox_cleaned_simplified.obj")
    middle = mesh.bounds.mean(axis=0)
    for frame in (0, 5, 11):
        rule = content["obj_scale"][frame] * (content["obj_rot"][frame] @ middle)
        rule += content["obj_trans"][frame, :, 0]
        found = placed(sequence.recorded["largebox"], frame, 0.25 * middle)
        assert np.abs(found - rule).max() < ROUNDING


@told
def test_a_clip_without_an_object(tmp_path):
    content = {k: v for k, v in fields().items() if not k.startswith("obj_")}
    sequence = load_sequence(written(tmp_path / "a.p", content))
    assert not sequence.scene.objects
    assert len(sequence.motion) == 12


@told
def test_written_as_it_came(tmp_path, assets):
    path = written(tmp_path / "a.p", fields(), fields(name=TWO))
    motion = hp.Motion.load(path, clip=TWO)
    motion.save(tmp_path / "b.p")
    again = pickle.loads((tmp_path / "b.p").read_bytes())
    assert list(again) == [1]  # its own id
    assert again[1].keys() == fields(name=TWO).keys()
    for key, value in fields(name=TWO).items():
        if isinstance(value, str):
            assert again[1][key] == value
        else:
            assert np.abs(again[1][key] - value).max() < ROUNDING, key
    # Between the frames too: the objects along with the person, and matrices stay rotations.
    motion.resample(60.0).save(tmp_path / "c.p")
    back = load_sequence(tmp_path / "c.p", assets, objects="replayed")
    assert len(back.recorded["mop_bottom"].position) == len(back.motion) == 23


def test_any_motion_is_written(tmp_path):
    translation, rotations = movement()
    rotations[:, 22:] = 0.0
    body = hp.Body.default()
    motion = hp.Motion(translation, rotations, 30.0, betas=np.ones(3), gender="female")
    motion.save(tmp_path / "jump.p", format="omomo")
    (clip,) = hp.clips(tmp_path / "jump.p")
    assert clip.name == "jump"
    back = clip.motion()
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < ROUNDING
    assert (back.gender, back.betas.tolist()) == ("female", [1.0] * 3 + [0.0] * 13)


def test_what_it_cannot_hold_is_said(tmp_path):
    from halfphysics.formats import losses

    translation, rotations = movement()
    motion = hp.Motion(translation, rotations, 60.0, betas=np.ones(20))
    assert losses(motion, tmp_path / "a.p") == [
        "the fingers",
        "jaw and eyes",
        "betas after the first 16",
        "the frame rate 60: readers take 30; say motion.resample(30)",
    ]


def wrong_rotation(matrices):
    matrices[4] *= 2.0
    return matrices


WRONG = [
    *usual("trans"),
    *usual("root_orient"),
    *usual("pose_body"),
    ("no shape", without("betas"), "'betas' is missing"),
    ("betas per frame", put("betas", np.random.default_rng(0).normal(size=(12, 16))), "changes"),
    ("betas NaN", put("betas", np.full((1, 16), np.nan)), "'betas'.*NaN"),
    ("betas of text", put("betas", "slim"), "'betas'.*expected numbers"),
    ("gender unknown", put("gender", "robot"), "gender: found 'robot'"),
    ("gender a number", put("gender", 3), "'gender'.*expected text"),
    ("name a number", put("seq_name", 3), "'seq_name'.*expected text"),
    ("name without object", put("seq_name", "sub3"), "'seq_name'.*expected SUBJECT_OBJECT"),
    ("no mesh", put("seq_name", "sub3_sofa_001"), "mesh of 'sofa'.*Looked for.*assets="),
    ("no obj_trans", without("obj_trans"), "'obj_trans' is missing"),
    ("obj_trans wide", put("obj_trans", np.zeros((12, 4))), "'obj_trans'"),
    ("obj_trans short", changed("obj_trans", lambda a: a[:-1]), "different length"),
    ("obj_trans NaN", spoilt("obj_trans", (2, 0, 0), np.nan), "'obj_trans'.*NaN.*frame 2"),
    ("no obj_rot", without("obj_rot"), "'obj_rot' is missing"),
    ("obj_rot as quaternions", put("obj_rot", np.zeros((12, 4))), "'obj_rot'.*3, 3"),
    ("obj_rot no rotation", changed("obj_rot", wrong_rotation), "frame 4 is no rotation"),
    ("obj_rot mirrored", changed("obj_rot", lambda a: -a), "no rotation"),
    ("no obj_scale", without("obj_scale"), "'obj_scale' is missing"),
    ("obj_scale zero", changed("obj_scale", lambda a: 0 * a), "'obj_scale'.*above 0"),
    ("obj_scale one number", put("obj_scale", np.array(0.3)), r"'obj_scale'.*\(T,\)"),
    ("half a bottom", put("obj_bottom_trans", np.zeros((12, 3, 1))), "_bottom_rot|mesh of"),
    ("one frame", lambda f: f.update({k: v[:1] for k, v in f.items() if len(v) == 12}), "1 frame"),
    ("a jump", spoilt("trans", (5, 0), 1e5), "m/s between frames"),
    ("windows", lambda f: f.update(motion=0, start_t_idx=0, end_t_idx=9), "windows for training"),
]


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(tmp_path, assets, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path / "bad.p", content), message, assets=assets)


def test_wrong_options_and_a_wrong_neighbour(tmp_path):
    path = written(tmp_path / "a.p", fields())
    with pytest.raises(hp.HalfPhysicsError, match="has no fingers"):
        hp.Motion.load(path, hands="flat")
    refused(written(tmp_path / "b.p", fields(), 5), "clip 1: found int")
    refused(written(tmp_path / "c.p", fields(), {}), "clip 1: field 'seq_name' is missing")


def test_hostile_and_broken_files(tmp_path):
    clip = fields()
    hostile_is_refused(tmp_path / "evil.p", {0: clip}, 1)
    hostile_is_refused(tmp_path / "worse.p", {0: {**clip}}, 0)
    broken_bytes_are_refused(written(tmp_path / "a.p", clip))
