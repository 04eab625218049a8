"""ARCTIC files: a pickled npy of the body, and beside it an object of two hinged parts."""

from __future__ import annotations

import json
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.motion.skeleton import BODY_JOINTS, LEFT_HAND_JOINTS, RIGHT_HAND_JOINTS
from support.files.layouts import movement, quiet
from support.files.linear_blend import lbs
from support.files.model_files import VERTICES, write_npz
from support.files.model_files import fields as model_fields
from support.files.wrong_files import (
    Boom,
    broken_bytes_are_refused,
    changed,
    put,
    refused,
    spoilt,
    usual,
    without,
)

FRAMES = 12
ROUNDING = 1e-12
SINGLE = 1e-6  # metres: meshes in files are in single precision


def fields() -> dict:
    """The layout of the data set's files."""
    translation, r = movement(FRAMES, up="z")
    return {
        "transl": translation,
        "global_orient": r[:, 0],
        "body_pose": r[:, list(BODY_JOINTS)].reshape(FRAMES, 63),
        "jaw_pose": r[:, 22],
        "leye_pose": r[:, 23],
        "reye_pose": r[:, 24],
        "left_hand_pose": r[:, list(LEFT_HAND_JOINTS)].reshape(FRAMES, 45),
        "right_hand_pose": r[:, list(RIGHT_HAND_JOINTS)].reshape(FRAMES, 45),
    }


def poses() -> np.ndarray:
    """Angle [rad], rotation (axis-angle) and translation [mm] of the object, frame by frame."""
    t = np.linspace(0.0, 1.0, FRAMES)[:, None]
    turn = np.array([0.2, -0.4, 1.1]) + t * np.array([0.3, 0.2, -0.5])
    place = np.array([300.0, -120.0, 900.0]) + t * np.array([50.0, 80.0, -30.0])
    return np.hstack([0.3 + 1.234567 * t, turn, place])


def written(root: Path, content: dict, thing: np.ndarray | None = None) -> Path:
    """The clip at its place in the data set's folder."""
    path = root / "data" / "raw_seqs" / "s01" / "box_grab_01.smplx.npy"
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, content, allow_pickle=True)
    np.save(path.with_name("box_grab_01.object.npy"), poses() if thing is None else thing)
    return path


@pytest.fixture
def data_set(tmp_path):
    """The clip with the meta folder, as the data set lies on a disk."""
    import trimesh

    path = written(tmp_path, fields())
    meta = tmp_path / "data" / "meta"
    parts = meta / "object_vtemplates" / "box"
    parts.mkdir(parents=True)
    for name, (x, y, z), at in (
        ("bottom", (200.0, 80.0, 150.0), (100.0, -40.0, 0.0)),
        ("top", (200.0, 10.0, 150.0), (100.0, 5.0, 0.0)),
    ):
        box = trimesh.creation.box((x, y, z))
        box.apply_translation(at)
        box.export(parts / f"{name}.obj")
    (meta / "misc.json").write_text(json.dumps({"s01": {"gender": "female", "image_size": [1]}}))
    (meta / "subject_vtemplates").mkdir()
    trimesh.Trimesh(template(), model_fields("smplx")["f"], process=False).export(
        meta / "subject_vtemplates" / "s01.obj", digits=17
    )
    return path


def template() -> np.ndarray:
    return np.random.default_rng(11).uniform(-0.7, 0.7, (VERTICES, 3))


def test_flat_hands_z_up_30_fps(data_set):
    motion = hp.Motion.load(data_set)
    assert (motion.fps, motion.model, motion.gender, motion.betas) == (
        30.0,
        "smplx",
        "female",
        None,
    )
    body = hp.Body.default()
    expected = body.vertices(hp.Motion(*movement(FRAMES, up="z"), 30.0))
    assert np.abs(body.vertices(motion) - expected).max() < ROUNDING


def test_a_hinge_that_does_not_move_makes_one_rigid_object(data_set, tmp_path):
    """Both parts in one mesh, the top turned as it is in the clip."""
    still = poses()
    still[:, 0] = 0.4
    path = written(tmp_path, fields(), still)
    sequence = quiet(path)
    assert not sequence.scene.articulated
    item, track = sequence.scene.objects["box"], sequence.recorded["box"]
    parts = data_set.parents[2] / "meta" / "object_vtemplates" / "box"
    import trimesh

    hinge = rot.rotvec_to_matrix([0.0, 0.0, -0.4])
    corners = [
        trimesh.load(parts / f"{part}.obj", process=False).vertices @ own.T / 1000.0
        for part, own in (("bottom", np.eye(3)), ("top", hinge))
    ]
    away = np.linalg.norm(np.concatenate(corners)[:, None] - item.visual.vertices, axis=-1)
    assert max(away.min(axis=0).max(), away.min(axis=1).max()) < SINGLE
    for frame in (0, FRAMES - 1):
        turn = rot.rotvec_to_matrix(still[frame, 1:4])
        point = turn @ [0.1, 0.2, 0.3] + still[frame, 4:] / 1000.0
        placed = rot.rotate(track.quaternion[frame], np.array([0.1, 0.2, 0.3]))
        assert np.abs(placed + track.position[frame] - point).max() < ROUNDING
    assert len(item.decomposition.pieces) == 2
    volume = 200.0 * 150.0 * (80.0 + 10.0) * 1e-9
    assert item.mass == pytest.approx(400.0 * volume, rel=1e-6)


def test_gender_may_be_said(data_set):
    assert hp.Motion.load(data_set, gender="male").gender == "male"
    (data_set.parents[2] / "meta" / "misc.json").unlink()
    with pytest.warns(hp.HalfPhysicsWarning, match="does not say a gender"):
        assert hp.Motion.load(data_set).gender == "neutral"


def test_written_as_it_came(data_set, tmp_path):
    motion = hp.Motion.load(data_set)
    motion.save(tmp_path / "again.smplx.npy")
    again = np.load(tmp_path / "again.smplx.npy", allow_pickle=True).item()
    assert again.keys() == fields().keys()
    for key, value in fields().items():
        assert np.abs(again[key] - value).max() < ROUNDING, key
    back = hp.Motion.load(tmp_path / "again.smplx.npy", gender="female")
    body = hp.Body.default()
    assert np.abs(body.vertices(back) - body.vertices(motion)).max() < ROUNDING
    assert hp.formats.losses(motion, tmp_path / "b.npy") == []
    other = hp.Motion(*movement(FRAMES, up="z"), 60.0, betas=np.ones(10), gender="male")
    lost = " ".join(hp.formats.losses(other, tmp_path / "b.npy", "arctic"))
    assert "shape" in lost
    assert "60" in lost
    assert "male" in lost
    assert "subject_vtemplates/s01.obj" in " ".join(hp.formats.losses(motion, tmp_path / "b.npz"))


def test_the_body_is_the_subjects_own(data_set, tmp_path, monkeypatch):
    monkeypatch.delenv("HALFPHYSICS_MODELS", raising=False)
    with pytest.warns(hp.HalfPhysicsWarning, match="needs the SMPL-X model.*SMPLX_FEMALE.npz"):
        assert hp.load_sequence(data_set, objects="replayed").body is None
    models = tmp_path / "models"
    write_npz(models / "smplx" / "SMPLX_FEMALE.npz", model_fields("smplx"))
    sequence = quiet(data_set, assets=models, objects="replayed")
    translation, r = movement(FRAMES, up="z")
    model = {**model_fields("smplx"), "v_template": template()}
    skin = np.array([lbs("smplx", model, np.zeros(0), r[i]) for i in range(FRAMES)])
    found = sequence.body.vertices(sequence.motion)
    assert np.abs(found - skin - translation[:, None]).max() < ROUNDING


def asked(part: str, vertices: np.ndarray, frame: int) -> np.ndarray:
    """The data set's own rule for vertices [mm], in metres."""
    pose = poses()[frame]
    if part == "top":
        c, s = np.cos(pose[0]), np.sin(pose[0])
        vertices = vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]).T
    return (vertices @ rot.rotvec_to_matrix(pose[1:4]).T + pose[4:]) / 1000.0


def millimetres(path: Path, part: str) -> np.ndarray:
    import trimesh

    return trimesh.load(path.parents[2] / f"meta/object_vtemplates/box/{part}.obj").vertices


def test_replayed_parts(data_set):
    sequence = quiet(data_set, objects="replayed")
    assert list(sequence.scene.objects) == ["box_bottom", "box_top"]
    for part in ("bottom", "top"):
        thing, track = sequence.scene.objects[f"box_{part}"], sequence.recorded[f"box_{part}"]
        vertices = millimetres(data_set, part)
        for frame in range(FRAMES):
            expected = asked(part, vertices, frame)
            placed = rot.rotate(track.quaternion[frame], vertices / 1000.0) + track.position[frame]
            assert np.abs(placed - expected).max() < SINGLE
        assert np.abs(thing.positions - track.position).max() < ROUNDING
        low, high = thing.mesh()[0].min(axis=0), thing.mesh()[0].max(axis=0)
        assert np.abs(low - vertices.min(axis=0) / 1000.0).max() < SINGLE
        assert np.abs(high - vertices.max(axis=0) / 1000.0).max() < SINGLE
    part = quiet(data_set, objects="replayed", frames=(2, 8))
    assert np.array_equal(
        part.recorded["box_top"].position, sequence.recorded["box_top"].position[2:8]
    )


def test_another_axis_up_turns_all_alike(data_set):
    """With the y-up option, person and object turn together."""
    as_z, as_y = (quiet(data_set, up=up, objects="replayed") for up in ("z", "y"))
    turn = as_y.motion.axes
    body = hp.Body.default()
    expected = body.vertices(as_z.motion) @ turn.T
    assert np.abs(body.vertices(as_y.motion) - expected).max() < ROUNDING
    for name in ("box_bottom", "box_top"):
        a, b = as_z.recorded[name], as_y.recorded[name]
        for frame in (0, 5, 11):
            placed = rot.rotate(a.quaternion[frame], np.eye(3)) + a.position[frame]
            found = rot.rotate(b.quaternion[frame], np.eye(3)) + b.position[frame]
            assert np.abs(found - placed @ turn.T).max() < ROUNDING


def test_a_free_object_has_a_hinge(data_set):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sequence = hp.load_sequence(data_set)
    texts = " ".join(str(one.message) for one in said)
    assert "what 'box' weighs" in texts
    assert "0.96 kg and 0.12 kg are taken" in texts
    box = sequence.scene.articulated["box"]
    assert box.link_names == ("box/bottom", "box/top")
    assert tuple(sequence.recorded) == box.link_names
    hinge = box.links[1].joints[0]
    assert (hinge.name, hinge.lower) == ("hinge", 0.0)
    assert poses()[:, 0].max() <= hinge.upper < poses()[:, 0].max() + 2e-3
    # The simulation starts with the links where the data set has them.
    simulator = hp.Simulator(sequence.scene, body=[], fps=30.0)
    first = simulator.reset([])
    assert abs(first.joints["box/hinge"] - 0.3) < ROUNDING
    for link, part in zip(box.links, ("bottom", "top"), strict=True):
        position, quaternion = first.objects[f"box/{part}"]
        placed = rot.rotate(quaternion, link.mesh()[0]) + position
        expected = asked(part, millimetres(data_set, part), 0)
        for bound in (np.min, np.max):
            assert np.abs(bound(placed, axis=0) - bound(expected, axis=0)).max() < SINGLE
        assert abs(link.mass - {"bottom": 0.96, "top": 0.12}[part]) < 1e-6
        centre = rot.rotate(quaternion, link.com) + position
        assert np.abs(centre - expected.mean(axis=0)).max() < SINGLE


def test_a_free_object_falls_as_a_whole(data_set):
    sequence = quiet(data_set)
    simulator = hp.Simulator(sequence.scene, body=[], fps=30.0)
    start = simulator.reset([]).objects["box/bottom"][0]
    for _ in range(9):
        frame = simulator.step([])
    fallen = frame.objects["box/bottom"][0]
    assert abs(start[2] - fallen[2] - 0.5 * 9.81 * 0.3**2) < 0.05
    hinge = sequence.scene.articulated["box"].links[1].joints[0]
    assert hinge.lower - 1e-9 <= frame.joints["box/hinge"] <= hinge.upper + 1e-9


@pytest.mark.parametrize("objects", ["free", "replayed"])
def test_simulated_kept_and_read_again(data_set, tmp_path, objects):
    away = poses() + np.array([0.0, 0.0, 0.0, 0.0, 2000.0, 0.0, 0.0])  # from the person
    sequence = quiet(written(tmp_path, fields(), away), objects=objects, frames=(0, 6))
    names = {"free": ["box/bottom", "box/top"], "replayed": ["box_bottom", "box_top"]}[objects]
    result = hp.simulate(sequence.motion, sequence.scene, body=hp.Body.default())
    result.save(tmp_path / "out.npz")
    again = hp.Result.load(tmp_path / "out.npz")
    assert list(again.objects) == names == list(sequence.recorded)
    for name in names:
        assert np.array_equal(again.objects[name].position, result.objects[name].position)
        start = result.objects[name].position[0] - sequence.recorded[name].position[0]
        assert np.abs(start).max() < SINGLE
    assert len(again.motion) == 6


def test_a_hollow_part_is_cut_into_pieces(data_set):
    pytest.importorskip("coacd")
    import trimesh

    # Five walls, so that there is room in it for a hand.
    walls = [
        trimesh.creation.box(size, transform=trimesh.transformations.translation_matrix(at))
        for size, at in (
            ((200.0, 10.0, 150.0), (100.0, -75.0, 0.0)),
            ((10.0, 70.0, 150.0), (5.0, -35.0, 0.0)),
            ((10.0, 70.0, 150.0), (195.0, -35.0, 0.0)),
            ((180.0, 70.0, 10.0), (100.0, -35.0, 70.0)),
            ((180.0, 70.0, 10.0), (100.0, -35.0, -70.0)),
        )
    ]
    folder = data_set.parents[2] / "meta" / "object_vtemplates" / "box"
    trimesh.util.concatenate(walls).export(folder / "bottom.obj")
    scene = quiet(data_set).scene
    geoms = scene.articulated["box"].links[0].geoms
    assert len(geoms) == 5
    # Together they are the walls, with nothing in the middle.
    given = np.concatenate([wall.vertices for wall in walls]) / 1000.0
    corners = [rot.rotate(g.quaternion, g.shape.vertices) + g.position for g in geoms]
    gap = np.linalg.norm(np.concatenate(corners)[:, None] - given[None], axis=2)
    assert max(gap.min(axis=1).max(), gap.min(axis=0).max()) < SINGLE
    middle = np.array([0.1, -0.035, 0.0])
    wall = np.array([0.1, -0.075, 0.0])
    for point, inside in ((middle, 0), (wall, 1)):
        own = [rot.rotate(rot.conjugate(g.quaternion), point - g.position) for g in geoms]
        met = [g.shape.depth(p[None])[0] > 0.0 for g, p in zip(geoms, own, strict=True)]
        assert sum(met) == inside


def test_scene_comes_back_from_a_file(data_set, tmp_path):
    scene = quiet(data_set).scene
    scene.save(tmp_path / "scene.yaml")
    again = hp.Scene.load(tmp_path / "scene.yaml").articulated["box"]
    box = scene.articulated["box"]
    assert again.joints == pytest.approx(dict(box.joints))
    for a, b in zip(again.links, box.links, strict=True):
        assert np.abs(a.mesh()[0].max(axis=0) - b.mesh()[0].max(axis=0)).max() < SINGLE
        assert abs(a.mass - b.mass) < 1e-5
        assert [j.upper for j in a.joints] == [j.upper for j in b.joints]


def test_what_lies_beside_a_clip_says_so(data_set):
    for name, content in (
        ("object", poses()),
        ("mano", {"left": {"rot": np.zeros((3, 3))}, "right": {"rot": np.zeros((3, 3))}}),
        ("egocam.dist", {"R_k_cam_np": np.zeros((3, 3, 3)), "T_k_cam_np": np.zeros((3, 3, 1))}),
    ):
        path = data_set.with_name(f"box_grab_01.{name}.npy")
        np.save(path, content, allow_pickle=True)
        refused(path, "of an ARCTIC clip.*Load box_grab_01.smplx.npy")
    assert [clip.path for clip in hp.clips(data_set.parents[1])] == [data_set]


WRONG = [
    *usual("transl"),
    *usual("body_pose"),
    *usual("left_hand_pose"),
    ("no root", without("global_orient"), "'global_orient' is missing"),
    ("no right hand", without("right_hand_pose"), "'right_hand_pose' is missing"),
    ("hand components", put("right_hand_pose", np.zeros((12, 24))), r"'right_.*\(T, 45\)"),
    ("no jaw", without("jaw_pose"), "'jaw_pose' is missing"),
    ("eye NaN", spoilt("reye_pose", (2, 0), np.nan), "'reye_pose'.*NaN"),
    ("matrices", put("global_orient", np.zeros((12, 3, 3))), "'global_orient'.*expected"),
    ("one frame", lambda f: f.update({k: v[:1] for k, v in f.items()}), "1 frame|different length"),
    ("in millimetres", changed("transl", lambda a: a * 1000.0), "m/s"),
    ("of None", put("body_pose", None), "'body_pose'.*expected"),
]  # fmt: skip


@pytest.mark.parametrize(("spoil", "message"), [c[1:] for c in WRONG], ids=[c[0] for c in WRONG])
def test_wrong_files(data_set, tmp_path, spoil, message):
    content = fields()
    spoil(content)
    refused(written(tmp_path, content), message)


def nan_in(array: np.ndarray) -> np.ndarray:
    array[4, 2] = np.nan
    return array


WRONG_OBJECTS = {
    "too wide": (np.zeros((12, 8)), r"'array'.*expected numbers of \(T, 7\)"),
    "too narrow": (np.zeros((12, 6)), r"'array'.*\(T, 7\)"),
    "flat": (np.zeros(84), r"'array'.*\(T, 7\)"),
    "too short": (poses()[:5], "different length"),
    "too long": (np.vstack([poses(), poses()]), "different length"),
    "NaN": (nan_in(poses()), "NaN.*frame 4"),
    "of text": (poses().astype(str), "expected numbers"),
    "empty": (np.zeros((0, 7)), "different length"),
    "a dict": (np.array({"pose": 1}, dtype=object), "'array'"),
}


@pytest.mark.parametrize("name", WRONG_OBJECTS)
def test_wrong_objects(data_set, tmp_path, name):
    thing, message = WRONG_OBJECTS[name]
    path = written(tmp_path, fields(), thing)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hp.HalfPhysicsWarning)
        with pytest.raises(hp.HalfPhysicsError, match=message) as caught:
            hp.load_sequence(path)
    assert "box_grab_01.object.npy" in str(caught.value)
    assert len(hp.Motion.load(path)) == FRAMES  # the person alone is well


def test_missing_neighbours(data_set):
    meta = data_set.parents[2] / "meta"
    top = meta / "object_vtemplates" / "box" / "top.obj"
    top.write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n")
    refused(data_set, "object 'box', top: .*span no volume")
    top.unlink()
    refused(data_set, "mesh of the top of 'box'.*Looked for.*object_vtemplates/box/top.obj")
    (meta / "misc.json").write_text("{")
    refused(data_set, "misc.json cannot be read.*gender=")
    data_set.with_name("box_grab_01.object.npy").unlink()
    refused(data_set, "its object is in box_grab_01.object.npy", gender="female")


def test_hostile_files(data_set, tmp_path):
    mark = tmp_path / "was_run"
    np.save(data_set, {**fields(), "transl": Boom(mark)}, allow_pickle=True)
    refused(data_set, "unsafe or unknown content")
    path = written(tmp_path, fields(), np.array(Boom(mark), dtype=object))
    with pytest.raises(hp.HalfPhysicsError, match=r"object\.npy.*unsafe or unknown content"):
        hp.load_sequence(path)
    assert not mark.exists()
    assert pickle.loads(pickle.dumps(Boom(mark))) is None  # the plain unpickler runs the payload
    assert mark.exists()


def test_broken_files(data_set):
    broken_bytes_are_refused(data_set)
