"""GRAB files: PCA hands on the mean hand, a template of the subject's own, objects in rows."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from support.carries.people import person
from support.files.grab_files import (
    FRAMES,
    fields,
    rotations,
    template,
    trajectory,
    written,
)
from support.files.layouts import quiet
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

ROUNDING = 1e-12
SINGLE = 1e-6  # metres: meshes in files are in single precision


@pytest.fixture
def data_set(tmp_path):
    """The clip, its meshes and the subject's template, as the data set lies on a disk."""
    import trimesh

    path = written(tmp_path, fields())
    tools = tmp_path / "GRAB" / "tools"
    meshes = tools / "object_meshes" / "contact_meshes"
    meshes.mkdir(parents=True)
    cup = trimesh.creation.box((0.08, 0.06, 0.1))
    cup.apply_translation((0.02, 0.01, 0.0))
    cup.export(meshes / "cup.ply")
    trimesh.creation.box((1.0, 0.8, 0.02)).export(meshes / "table.ply")
    subjects = tools / "subject_meshes" / "male"
    subjects.mkdir(parents=True)
    shape = trimesh.Trimesh(template(), model_fields("smplx")["f"], process=False)
    shape.export(subjects / "s1.ply")
    return path


def asked() -> np.ndarray:
    """Vertices (T, V, 3) by the equations of the SMPL-X paper, on the subject's template."""
    model = {**model_fields("smplx"), "v_template": template()}
    translation, r = rotations()
    return np.array(
        [lbs("smplx", model, np.zeros(0), r[i]) + translation[i] for i in range(FRAMES)]
    )


def test_hands_are_unfolded_without_a_model(data_set):
    motion = hp.Motion.load(data_set)
    assert (motion.fps, motion.model, motion.gender, motion.betas) == (120.0, "smplx", "male", None)
    translation, r = rotations()
    body = hp.Body.default()
    expected = body.vertices(hp.Motion(translation, r, 120.0))
    assert np.abs(body.vertices(motion) - expected).max() < ROUNDING
    assert motion.origin.fields["obj_name"] == "cup"


def test_hands_by_the_users_model_where_the_file_has_components_only(tmp_path, monkeypatch):
    path = written(tmp_path, fields(full=False))
    monkeypatch.delenv("HALFPHYSICS_MODELS", raising=False)
    refused(path, "hands of 24 principal.*Looked for.*SMPLX_MALE.npz.*HALFPHYSICS_MODELS")
    expected = rotations()[1]
    # Named, in a folder of the smplx package's layout, and by the environment.
    models = tmp_path / "models"
    file = write_npz(models / "smplx" / "SMPLX_MALE.npz", model_fields("smplx"))
    for options in ({"model": file}, {"model": models}, {"assets": models}):
        motion = hp.Motion.load(path, **options)
        assert np.abs(motion.rotations - expected).max() < ROUNDING
    monkeypatch.setenv("HALFPHYSICS_MODELS", str(models))
    assert np.abs(hp.Motion.load(path).rotations - expected).max() < ROUNDING


def test_a_model_that_the_hands_were_not_made_with_is_said(data_set, tmp_path):
    file = write_npz(tmp_path / "SMPLX_MALE.npz", model_fields("smplx", seed=4))
    with pytest.warns(hp.HalfPhysicsWarning, match="differ by up to .* rad .*'fullpose'"):
        hp.Motion.load(data_set, model=file)
    bare = {k: v for k, v in model_fields("smplx").items() if not k.startswith("hands_")}
    refused(
        data_set,
        "no fields hands_mean",
        model=write_npz(data_set.parent / "cup_lift.npz_model.npz", bare),
    )


def test_the_body_is_the_subjects_own(data_set, tmp_path):
    models = tmp_path / "models"
    write_npz(models / "SMPLX_MALE.npz", model_fields("smplx"))
    sequence = quiet(data_set, assets=models)
    found = sequence.body.vertices(sequence.motion)
    assert np.abs(found - asked()).max() < ROUNDING
    assert sequence.body.template_source.path.endswith("s1.ply")


def test_without_template_or_model_the_body_is_missing_and_said(data_set, tmp_path, monkeypatch):
    monkeypatch.delenv("HALFPHYSICS_MODELS", raising=False)
    with pytest.warns(hp.HalfPhysicsWarning, match="the SMPL-X model.*Looked for.*SMPLX_MALE"):
        assert load_sequence(data_set, objects="replayed").body is None
    other = write_npz(tmp_path / "SMPLX_FEMALE.npz", model_fields("smplx"))
    with pytest.warns(hp.HalfPhysicsWarning, match="female by its name, expected the male"):
        assert load_sequence(data_set, objects="replayed", model=other).body is None
    (data_set.parents[2] / "tools/subject_meshes/male/s1.ply").unlink()
    with pytest.warns(hp.HalfPhysicsWarning, match="own template.*Looked for .*s1.ply in"):
        assert load_sequence(data_set, objects="replayed", model=other).body is None


def test_without_a_model_the_body_has_the_templates_size(data_set, monkeypatch):
    import trimesh

    monkeypatch.delenv("HALFPHYSICS_MODELS", raising=False)
    own = person(1.6, 0.95)
    skin = trimesh.Trimesh(own.rest_vertices, own.faces, process=False)
    skin.export(data_set.parents[2] / "tools/subject_meshes/male/s1.ply")
    with pytest.warns(hp.HalfPhysicsWarning, match="with the template's size: stature 1.60 m"):
        sequence = load_sequence(data_set, objects="replayed")
    away = sequence.body.joints(sequence.motion) - own.joints(sequence.motion)
    assert np.linalg.norm(away, axis=-1).max() < 1e-3


def rows(vertices: np.ndarray, params: dict, frame: int) -> np.ndarray:
    """The data set's own rule for its vertices."""
    turn = rot.rotvec_to_matrix(params["global_orient"][frame])
    return vertices @ turn + params["transl"][frame]


def test_object_and_table(data_set):
    sequence = quiet(data_set)
    cup, track = sequence.scene.objects["cup"], sequence.recorded["cup"]
    vertices = cup.visual.vertices
    for frame in range(FRAMES):
        placed = rot.rotate(track.quaternion[frame], vertices) + track.position[frame]
        assert np.abs(placed - rows(vertices, trajectory(7), frame)).max() < SINGLE
    assert np.array_equal(cup.position, track.position[0])
    assert abs(cup.mass - 400.0 * 0.08 * 0.06 * 0.1) < 1e-6
    table = sequence.scene.statics["table"]
    placed = rot.rotate(table.quaternion, table.shape.vertices) + table.position
    assert np.abs(placed - rows(table.shape.vertices, trajectory(9), 0)).max() < SINGLE
    replayed = quiet(data_set, objects="replayed", frames=(3, 9))
    assert np.array_equal(replayed.scene.objects["cup"].positions, track.position[3:9])
    assert len(replayed.motion) == 6


def test_a_table_that_is_pushed_moves_as_recorded(data_set, tmp_path):
    content = fields()
    content["table"]["params"] = trajectory(9)
    sequence = quiet(written(tmp_path, content))
    table = sequence.scene.objects["table"]
    vertices = table.visual.vertices
    assert "table" not in sequence.scene.statics
    for frame in (0, FRAMES - 1):
        placed = rot.rotate(table.quaternions[frame], vertices) + table.positions[frame]
        assert np.abs(placed - rows(vertices, trajectory(9), frame)).max() < SINGLE
    assert table.fps == 120.0


def test_a_cup_on_the_table_stays_there(data_set, tmp_path):
    content = fields()
    for key, height in (("table", 0.7), ("object", 0.7 + 0.01 + 0.05)):
        params = content[key]["params"]
        params["transl"] = np.tile([0.1, 0.2, height], (FRAMES, 1))
        params["global_orient"] = np.tile([0.0, 0.0, 0.4], (FRAMES, 1))
    scene = quiet(written(tmp_path, content)).scene
    simulator = hp.Simulator(scene, body=[], fps=120.0)
    start = simulator.reset([]).objects["cup"][0]
    for _ in range(60):
        frame = simulator.step([])
    assert np.linalg.norm(frame.objects["cup"][0] - start) < 1e-3


def test_another_axis_up_turns_all_alike(data_set):
    """With the y-up option, person, object and table turn together."""
    as_z, as_y = (quiet(data_set, up=up) for up in ("z", "y"))
    turn = as_y.motion.axes
    body = hp.Body.default()
    expected = body.vertices(as_z.motion) @ turn.T
    assert np.abs(body.vertices(as_y.motion) - expected).max() < ROUNDING
    for name in ("cup", "table"):
        a, b = ({**s.scene.objects, **s.scene.statics}[name] for s in (as_z, as_y))
        corners = np.eye(3)
        placed = rot.rotate(a.quaternion, corners) + a.position
        assert np.abs(rot.rotate(b.quaternion, corners) + b.position - placed @ turn.T).max() < (
            ROUNDING
        )


def test_a_file_without_a_table(data_set, tmp_path):
    content = fields()
    del content["table"], content["contact"]
    assert list(quiet(written(tmp_path, content)).scene.statics) == ["ground"]


def test_saved_as_amass(data_set, tmp_path):
    motion = hp.Motion.load(data_set)
    motion.save(tmp_path / "out.npz")
    (lost,) = hp.formats.losses(motion, tmp_path / "out.npz")
    assert "tools/subject_meshes/male/s1.ply" in lost
    again = hp.Motion.load(tmp_path / "out.npz")
    body = hp.Body.default()
    assert np.abs(body.vertices(again) - body.vertices(motion)).max() < ROUNDING
    with pytest.raises(hp.HalfPhysicsError, match="'grab' can only be read"):
        motion.save(tmp_path / "again.npz", format="grab")


@pytest.mark.parametrize("objects", ["free", "replayed"])
@pytest.mark.filterwarnings("ignore:person starts")
def test_simulated_kept_and_read_again(data_set, tmp_path, objects):
    sequence = quiet(data_set, objects=objects, frames=(0, 6))
    names = {"free": ["cup"], "replayed": ["cup"]}[objects]
    result = hp.simulate(sequence.motion, sequence.scene, body=hp.Body.default())
    result.save(tmp_path / "out.npz")
    again = hp.Result.load(tmp_path / "out.npz")
    assert list(again.objects) == names == list(sequence.recorded)
    for name in names:
        assert np.array_equal(again.objects[name].position, result.objects[name].position)
        start = result.objects[name].position[0] - sequence.recorded[name].position[0]
        assert np.abs(start).max() < SINGLE
    assert len(again.motion) == 6


def test_in_a_library(data_set):
    assert [clip.format for clip in hp.clips(data_set.parents[2])] == ["grab"]


def inside(part: str, spoil):
    """Spoil the parameters of a part of the file."""
    return lambda f: spoil(f[part]["params"])


WRONG = [
    *[(f"body: {n}", inside("body", s), m) for n, s, m in usual("transl")],
    *[(f"body: {n}", inside("body", s), m) for n, s, m in usual("body_pose")],
    *[(f"object: {n}", inside("object", s), m) for n, s, m in usual("global_orient")],
    *[(f"table: {n}", inside("table", s), m) for n, s, m in usual("transl")],
    ("no body", without("body"), "'body' is missing"),
    ("no object", without("object"), "'object' is missing"),
    ("body an array", put("body", np.zeros(3)), "'body'.*expected a dict"),
    ("object a text", put("object", "cup"), "'object'.*expected a dict"),
    ("no params", lambda f: f["body"].pop("params"), "'params' is missing"),
    ("params a list", lambda f: f["body"].update(params=[1]), "'params'.*expected a dict"),
    ("no template", lambda f: f["body"].pop("vtemp"), "'vtemp' is missing"),
    ("no mesh", lambda f: f["object"].pop("object_mesh"), "'object_mesh' is missing"),
    ("no gender", without("gender"), "'gender' is missing"),
    ("gender unknown", put("gender", "robot"), "gender: found 'robot'"),
    ("no rate", without("framerate"), "'framerate' is missing"),
    ("rate negative", put("framerate", -120.0), "'framerate'.*expected a number"),
    ("rate NaN", put("framerate", np.nan), "'framerate'.*expected a number"),
    ("rate a text", put("framerate", "fast"), "'framerate'.*expected a number"),
    ("frames wrong", put("n_frames", 13), "different length"),
    ("no components", without("n_comps"), "'n_comps' is missing"),
    ("components zero", put("n_comps", 0), "'n_comps'.*between 0 and 46"),
    ("components many", put("n_comps", 60), "'n_comps'.*between 0 and 46"),
    ("components other", put("n_comps", 12), r"'left_hand_pose'.*\(T, 12\)"),
    ("hands missing", inside("body", without("right_hand_pose")), "'right_hand_pose' is missing"),
    ("full narrow", inside("body", changed("fullpose", lambda a: a[:, :150])), "'fullpose'"),
    ("object unknown", put("obj_name", np.zeros(3)), "'obj_name'.*expected text"),
    ("object with a slash", put("obj_name", "cup/mug"), "without '/'"),
    ("object called as the table", put("obj_name", "table"), "already"),
    ("object called person", put("obj_name", "person"), "means the people"),
    ("ragged", lambda f: f["body"]["params"].update(jaw_pose=[[1.0], [1.0, 2.0]]), "'jaw_pose'"),
    ("too fast", inside("body", changed("transl", lambda a: a * 1e4)), "m/s"),
    (
        "mesh elsewhere",
        lambda f: f["object"].update(object_mesh="../../../secret.ply"),
        "mesh of 'cup'.*Looked for secret.ply in",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(data_set, tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path, content), message)


def test_wrong_meshes(data_set, tmp_path):
    import trimesh

    tools = data_set.parents[2] / "tools"
    cup = tools / "object_meshes" / "contact_meshes" / "cup.ply"
    good = cup.read_bytes()
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    flat.export(cup)
    refused(data_set, "span no volume")
    refused(data_set, "kinematic object 'cup'.*span no volume", objects="replayed")
    cup.write_bytes(good[:40])
    with pytest.raises(hp.HalfPhysicsError, match=r"cup\.ply: cannot be read"):
        quiet(data_set)
    cup.write_bytes(good)
    models = tmp_path / "models"
    write_npz(models / "SMPLX_MALE.npz", model_fields("smplx"))
    small = trimesh.creation.box((1, 1, 1))
    small.export(tools / "subject_meshes" / "male" / "s1.ply")
    with pytest.raises(hp.HalfPhysicsError, match=r"s1\.ply: found shape \(8, 3\)"):
        quiet(data_set, assets=models)


def test_options_that_do_not_fit(data_set):
    refused(data_set, "hands: found 'mean'.*says itself", hands="mean")


@pytest.mark.parametrize("key", ["body", "object", "gender"])
def test_hostile_files(data_set, tmp_path, key):
    mark = tmp_path / "was_run"
    content = {**fields(), key: np.array(Boom(mark), dtype=object)}
    refused(written(tmp_path, content), f"field '{key}'.*unsafe or unknown content")
    assert not mark.exists()


def test_broken_files(data_set):
    broken_bytes_are_refused(data_set)
