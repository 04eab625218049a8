"""Results: what they check, what their files hold, and what damaged files say."""

from __future__ import annotations

import dataclasses
import io
import json
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics import rotations as rot
from halfphysics.axes import axes_of
from halfphysics.body import Body
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.io.npz import write_npz
from halfphysics.motion import Motion
from halfphysics.result import VECTORS, Contacts, ObjectTrack, PersonResult, Result, Substeps
from halfphysics.scene import Scene
from halfphysics.settings import Settings
from halfphysics.shapes import Box, Capsule, Plane, Sphere

COLUMNS = [f.name for f in dataclasses.fields(Contacts)]


@pytest.fixture(scope="module")
def body():
    return Body.default()


def make_result(body, seed=0, people=1, frames=5, axes="z", scene=None, model="smplx", **changes):
    """A result of random numbers."""
    rng = np.random.default_rng(seed)

    def random():
        return 0.05 * rng.normal(size=(frames, 3)), rng.normal(size=(frames, 55, 3))

    def person(name):
        shape = {"betas": rng.normal(size=4), "gender": "female", "model": model}
        reference = Motion(*random(), 29.97, **shape, axes=axes_of(axes))
        motion = reference.with_frames(*random())
        return PersonResult(name=name, motion=motion, reference=reference, body=body)

    def track(n):
        return ObjectTrack(position=rng.normal(size=(n, 3)), quaternion=rng.normal(size=(n, 4)))

    if scene is None:
        scene = Scene(gravity=(0.1, 0.2, -9.0))
        scene.add_static("floor", Plane(offset=-1.0 / 3.0))
        scene.add_static("wall", Box((0.1, 0.2, 0.3)), position=rng.normal(size=3), friction=0.3)
        quaternion = rng.normal(size=4)
        scene.add_object("ball", Sphere(0.11), mass=0.43, quaternion=quaternion, restitution=0.5)
        scene.add_object("stick", Capsule(0.1, 1.0), density=300.0, com=(0.0, 0.0, 0.1))
        scene.friction("person", "ball", 0.25)
        scene.ignore("stick", "wall")
    names = [f"person{i}" for i in range(people)]
    every = (*scene.statics, *scene.objects, *names)
    n = int(rng.integers(0, 30))
    low = {"person": -1, "part": -1, "subject": -1, "other_part": -1}
    high = {"frame": frames, "person": people, "part": 55, "other_part": 55}
    columns = {
        name: rng.normal(size=(n, 3))
        if name in VECTORS
        else rng.integers(low.get(name, 0), high.get(name, len(every)), size=n)
        for name in COLUMNS
    }
    arguments = {
        "people": [person(name) for name in names],
        "objects": {name: track(frames) for name in scene.objects},
        "scene": scene,
        "names": every,
        "contacts": Contacts(**columns),
        "clearance": np.where(rng.random(frames) < 0.5, np.inf, rng.normal(size=frames)),
        "lost_time": rng.random(frames),
        "diagnostics": {"passes": rng.random(frames), "residual": rng.random(frames)},
        "settings": Settings(stiffness=float(rng.random()), drive_time=None, substeps=3),
    }
    return Result(**(arguments | changes))


def assert_same(a: Result, b: Result) -> None:
    """Equal to the last bit."""
    assert a.names == b.names
    assert a.settings == b.settings
    assert a.fps == b.fps
    np.testing.assert_array_equal(a.clearance, b.clearance)
    np.testing.assert_array_equal(a.lost_time, b.lost_time)
    assert sorted(a.diagnostics) == sorted(b.diagnostics)
    for name, values in a.diagnostics.items():
        np.testing.assert_array_equal(values, b.diagnostics[name])
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(a.contacts, column), getattr(b.contacts, column))
    assert list(a.objects) == list(b.objects)
    for name, track in a.objects.items():
        np.testing.assert_array_equal(track.position, b.objects[name].position)
        np.testing.assert_array_equal(track.quaternion, b.objects[name].quaternion)
    assert len(a.people) == len(b.people)
    for p, q in zip(a.people, b.people, strict=True):
        assert p.name == q.name
        for m, n in ((p.motion, q.motion), (p.reference, q.reference)):
            for field in ("translation", "rotations", "axes", "betas"):
                np.testing.assert_array_equal(getattr(m, field), getattr(n, field))
            assert (m.fps, m.gender, m.model) == (n.fps, n.gender, n.model)
        np.testing.assert_array_equal(p.body.rest_vertices, q.body.rest_vertices)


@given(
    seed=st.integers(0, 2**32 - 1),
    people=st.integers(1, 3),
    frames=st.integers(2, 6),
    axes=st.sampled_from("zy"),
    model=st.sampled_from(["smplx", "smplh", "smpl"]),
)
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_a_file_gives_back_every_bit(tmp_path, body, seed, people, frames, axes, model):
    result = make_result(body, seed, people, frames, axes, model=model)
    path = tmp_path / "result.npz"
    result.save(path)
    loaded = Result.load(path)
    assert_same(result, loaded)
    before, after = result.scene, loaded.scene
    np.testing.assert_array_equal(before.gravity, after.gravity)
    assert before.friction_pairs == after.friction_pairs
    assert before.ignored_pairs == after.ignored_pairs
    for name, thing in {**before.statics, **before.objects}.items():
        again = {**after.statics, **after.objects}[name]
        assert thing.shape == again.shape
        np.testing.assert_array_equal(thing.position, again.position)
        np.testing.assert_array_equal(thing.quaternion, again.quaternion)
        assert (thing.friction, thing.restitution) == (again.friction, again.restitution)
    for name, thing in before.objects.items():
        assert thing.mass == after.objects[name].mass
        np.testing.assert_array_equal(thing.com, after.objects[name].com)
        # Sums of the same solid, from another mass or density: rounding only.
        np.testing.assert_allclose(thing.inertia, after.objects[name].inertia, rtol=1e-14)
    # Written again: the same bytes.
    loaded.save(tmp_path / "again.npz")
    assert path.read_bytes() == (tmp_path / "again.npz").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again.npz", "result.npz"]


@pytest.mark.parametrize("axes", ["z", "y"])
@pytest.mark.parametrize("model", ["smplx", "smplh", "smpl"])
def test_a_motion_reader_opens_it(tmp_path, body, axes, model):
    result = make_result(body, axes=axes, model=model)
    result.save(tmp_path / "r.npz")
    motion = Motion.load(tmp_path / "r.npz", up=axes)
    # Turned to the file's axes and back: rounding only, of numbers of size 1.
    np.testing.assert_allclose(motion.translation, result.motion.translation, atol=1e-14)
    np.testing.assert_allclose(
        rot.rotvec_to_matrix(motion.rotations),
        rot.rotvec_to_matrix(result.motion.rotations),
        atol=1e-13,
    )
    assert (motion.fps, motion.gender, motion.model) == (29.97, "female", model)
    with np.load(tmp_path / "r.npz", allow_pickle=False) as file:  # as any reader of AMASS does
        assert file["trans"].shape == (5, 3)
        assert file["poses"].shape == (5, {"smplx": 165, "smplh": 156, "smpl": 72}[model])
        others = {k for k in file if "/" in k}
        assert {k.split("/")[0] for k in others} == {"object", "contact", "meta"}
        np.testing.assert_array_equal(file["object/ball/position"], result.objects["ball"].position)
        np.testing.assert_array_equal(file["contact/impulse"], result.contacts.impulse)


def test_keys_of_the_input_file_are_kept(tmp_path, body):
    rng = np.random.default_rng(1)
    given = {
        "trans": rng.normal(size=(4, 3)).astype(np.float32) * 0.05,
        "poses": rng.normal(size=(4, 156)).astype(np.float32),
        "dmpls": rng.normal(size=(4, 8)),
        "betas": rng.normal(size=16),
        "gender": np.array(b"male"),
        "mocap_framerate": np.array(120.0),
    }
    np.savez(tmp_path / "in.npz", **given)
    motion = Motion.load(tmp_path / "in.npz")
    moved = motion.with_frames(motion.translation + np.array([0.25, 0, 0]), motion.rotations)
    person = PersonResult(name="person0", motion=moved, reference=motion, body=body)
    scene = Scene()
    result = make_result(body, frames=4, scene=scene, people=1, contacts=Contacts.none())
    result = dataclasses.replace(result, people=(person,))
    result.save(tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as file:
        assert [k for k in file if "/" not in k] == list(given)
        np.testing.assert_array_equal(file["poses"], given["poses"])
        np.testing.assert_array_equal(file["dmpls"], given["dmpls"])
        np.testing.assert_allclose(file["trans"], given["trans"] + [0.25, 0, 0], atol=1e-7)
    again = Result.load(tmp_path / "out.npz")
    again.save(tmp_path / "again.npz")
    assert (tmp_path / "out.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()


def test_substeps_come_back(tmp_path, body):
    rng = np.random.default_rng(3)
    result = make_result(body, people=2)
    fine = tuple(
        p.motion.with_frames(0.01 * rng.normal(size=(9, 3)), rng.normal(size=(9, 55, 3)), 60.0)
        for p in result.people
    )
    tracks = {
        name: ObjectTrack(position=rng.normal(size=(9, 3)), quaternion=rng.normal(size=(9, 4)))
        for name in result.objects
    }
    result = dataclasses.replace(result, substeps=Substeps(motions=fine, objects=tracks))
    result.save(tmp_path / "r.npz")
    loaded = Result.load(tmp_path / "r.npz").substeps
    assert loaded is not None
    for a, b in zip(fine, loaded.motions, strict=True):
        np.testing.assert_array_equal(a.rotations, b.rotations)
        assert b.fps == 60.0
    np.testing.assert_array_equal(tracks["ball"].quaternion, loaded.objects["ball"].quaternion)
    make_result(body).save(tmp_path / "plain.npz")
    assert Result.load(tmp_path / "plain.npz").substeps is None


def test_another_shape_and_stature_come_back(tmp_path):
    body = Body.default(betas=[0.5, -1.0], stature=1.9)
    make_result(body).save(tmp_path / "r.npz")
    again = Result.load(tmp_path / "r.npz").people[0].body
    # Scaled from the same shape by the same factor, which is computed from a rounded stature.
    np.testing.assert_allclose(again.rest_vertices, body.rest_vertices, atol=1e-14)


TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def mesh_scene(folder):
    (folder / "tetra.obj").write_text(TETRA)
    scene = Scene()
    scene.add_static("floor", Plane())
    scene.add_static("rock", folder / "tetra.obj", scale=2.0, position=(1, 2, 3))
    scene.friction("floor", "person", 0.5)
    scene.friction("rock", "person", 0.25)
    return scene


def test_meshes_are_named_not_copied(tmp_path, body):
    make_result(body, scene=mesh_scene(tmp_path)).save(tmp_path / "r.npz")
    with np.load(tmp_path / "r.npz") as file:
        rock = json.loads(str(file["meta/scene"]))["statics"]["rock"]
    assert rock["mesh"] == str(tmp_path / "tetra.obj")
    assert len(rock["sha256"]) == 64
    scene = Result.load(tmp_path / "r.npz").scene
    assert np.ptp(scene.statics["rock"].shape.vertices, axis=0).tolist() == [2, 2, 2]
    assert scene.friction_of("rock", "person") == 0.25


def test_a_mesh_that_has_gone_is_left_out_with_a_warning(tmp_path, body):
    scene = mesh_scene(tmp_path)
    make_result(body, scene=scene).save(tmp_path / "r.npz")
    (tmp_path / "tetra.obj").unlink()
    result = Result.load(tmp_path / "r.npz")  # nothing is said until the scene is asked for
    assert result.names == ("floor", "rock", "person0")
    with pytest.warns(HalfPhysicsWarning, match=r"rock \(.*tetra.obj is not there\).*scene="):
        assert list(result.scene.statics) == ["floor"]
    result.save(tmp_path / "again.npz")  # the reference is kept
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "r.npz").read_bytes()
    assert list(Result.load(tmp_path / "r.npz", scene=scene).scene.statics) == ["floor", "rock"]


def test_a_mesh_that_changed_is_said(tmp_path, body):
    make_result(body, scene=mesh_scene(tmp_path)).save(tmp_path / "r.npz")
    (tmp_path / "tetra.obj").write_text(TETRA.replace("v 0 0 1", "v 0 0 2"))
    with pytest.warns(HalfPhysicsWarning, match="has changed"):
        _ = Result.load(tmp_path / "r.npz").scene


def test_a_mesh_from_memory_is_not_written(tmp_path, body):
    import trimesh

    scene = Scene()
    scene.add_static("box", trimesh.creation.box((1.0, 2.0, 3.0)))
    make_result(body, scene=scene).save(tmp_path / "r.npz")
    with np.load(tmp_path / "r.npz") as file:
        mesh = json.loads(str(file["meta/scene"]))["statics"]["box"]["mesh"]
    assert set(mesh["in_memory"]) == {"vertices", "faces", "sha256"}
    assert mesh["in_memory"]["vertices"] == 8
    with pytest.warns(HalfPhysicsWarning, match="box .its mesh came from no file"):
        assert not Result.load(tmp_path / "r.npz").scene.statics


def test_a_body_model_is_named_not_copied(tmp_path, body):
    """A model file in SMPL-X layout (the default body's own data) stands for a licensed one."""
    from halfphysics import body as module

    model = tmp_path / "SMPLX_NEUTRAL.npz"
    model.write_bytes(module._ASSET.read_bytes())
    licensed = Body.load(model, betas=[1.0, 2.0])
    result = make_result(licensed)
    result.save(tmp_path / "r.npz")
    assert (tmp_path / "r.npz").stat().st_size < 100_000  # no skin in it
    again = Result.load(tmp_path / "r.npz").people[0].body
    np.testing.assert_array_equal(again.rest_vertices, licensed.rest_vertices)
    changed = model.read_bytes()
    with zipfile.ZipFile(model, "a") as archive:
        archive.writestr("more.txt", "x")
    with pytest.raises(FileError, match=r"SMPLX_NEUTRAL.npz has changed.*body="):
        _ = Result.load(tmp_path / "r.npz").people[0].body
    model.unlink()
    loaded = Result.load(tmp_path / "r.npz")
    with pytest.raises(FileError, match=r"SMPLX_NEUTRAL.npz is not there.*body="):
        _ = loaded.people[0].body
    loaded.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "r.npz").read_bytes()
    assert Result.load(tmp_path / "r.npz", body=body).people[0].body is body
    assert len(changed) > 100_000


def test_several_bodies_are_counted(tmp_path, body):
    make_result(body, people=2).save(tmp_path / "r.npz")
    with pytest.raises(FileError, match="found 3 bodies, expected 2"):
        Result.load(tmp_path / "r.npz", body=[body] * 3)


# -- damaged files -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(body, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "r.npz"
    make_result(body, people=2).save(path)
    with np.load(path) as file:
        return {key: file[key] for key in file}, path.read_bytes()


@pytest.mark.parametrize("share", [0.01, 0.3, 0.6, 0.9, 0.999])
def test_truncated(tmp_path, saved, share):
    path = tmp_path / "r.npz"
    path.write_bytes(saved[1][: int(share * len(saved[1]))])
    with pytest.raises(FileError, match=r"r\.npz"):
        Result.load(path)


@pytest.mark.parametrize("seed", range(4))
def test_a_changed_byte_is_found_or_harmless(tmp_path, saved, seed):
    """Whatever is damaged: the arrays that come back are right, or it is a FileError."""
    rng = np.random.default_rng(seed)
    path = tmp_path / "r.npz"
    refused = 0
    for _ in range(25):
        raw = bytearray(saved[1])
        raw[rng.integers(len(raw))] ^= int(rng.integers(1, 256))
        path.write_bytes(raw)
        try:
            result = Result.load(path)
        except FileError:
            refused += 1
        else:
            np.testing.assert_array_equal(result.motion.rotations, saved[0]["meta/rotations"])
            np.testing.assert_array_equal(result.contacts.impulse, saved[0]["contact/impulse"])
    assert refused > 10  # most bytes are data


@pytest.mark.parametrize("at", [60, 100, 140])
def test_a_damaged_array_header(tmp_path, saved, at):
    """numpy reads headers as Python source, which fails in ways of its own."""
    with zipfile.ZipFile(tmp_path / "r.npz", "w") as archive:
        for key, value in saved[0].items():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, value)
            raw = bytearray(stream.getvalue())
            if key == "meta/translation":
                raw[10 : at - 20] = b"(" * (at - 30)
            archive.writestr(f"{key}.npy", bytes(raw))
    with pytest.raises(FileError, match="field 'meta/translation' is damaged"):
        Result.load(tmp_path / "r.npz")


def _json_of(value):
    return np.array(json.dumps(value))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("meta/format_version", None, "found no 'meta/format_version'.*Motion.load"),
        ("meta/format_version", np.array(99), r"found 99, expected 1.*newer"),
        ("meta/people", None, "field 'meta/people' is missing"),
        ("meta/people", np.array("{"), "field 'meta/people': not valid JSON"),
        ("meta/people", _json_of([]), "no people"),
        ("meta/people", _json_of([{"name": "a"}]), "body of person 0"),
        ("meta/people", np.zeros(3), "expected JSON text"),
        ("meta/settings", _json_of({"stiffness": -1.0}), "stiffness is -1.0"),
        ("meta/settings", _json_of({"stifness": 1.0}), "unknown settings .'stifness'"),
        ("meta/scene", _json_of({"statics": {}}), "field 'meta/scene': found.*expected version"),
        ("meta/fps", np.array("x"), "field 'meta/fps'.*expected a number"),
        ("meta/fps", np.array(-30.0), "fps: found -30.0"),
        ("meta/names", np.arange(3), "field 'meta/names'"),
        ("meta/names", np.array(["ball", "floor"]), "names: found ball, floor"),
        ("meta/rotations", np.full((5, 55, 3), np.nan), "rotations: 825 values are NaN"),
        ("meta/rotations", np.zeros((5, 54, 3)), r"rotations: found shape \(5, 54, 3\)"),
        ("meta/clearance", np.zeros(4), r"found lengths .*'clearance': 4.*expected 5"),
        ("meta/clearance", np.full(5, np.nan), "clearance: found .* with 5 NaN"),
        ("object/ball/position", np.zeros((4, 3)), "position has 4 frames and quaternion 5"),
        ("object/ball/quaternion", None, "field 'object/ball/quaternion' is missing"),
        ("contact/frame", np.array([0.5]), "contacts.frame.*whole numbers"),
        ("contact/part", np.array([1]), r"contacts.part: found 1 rows"),
        ("person/1/rotations", None, "field 'person/1/rotations' is missing"),
        ("poses", np.zeros((5, 165)), "changed after it was written"),
    ],
)
def test_wrong_fields(tmp_path, saved, key, value, message):
    fields = dict(saved[0])
    if value is None:
        del fields[key]
    else:
        fields[key] = value
    path = tmp_path / "r.npz"
    write_npz(path, fields)
    with pytest.raises(FileError, match=message) as caught:
        Result.load(path)
    assert str(path) in str(caught.value)


def test_contacts_beyond_the_result_are_refused(tmp_path, saved):
    fields = dict(saved[0])
    fields["contact/frame"] = np.full(len(fields["contact/frame"]), 5)
    write_npz(tmp_path / "r.npz", fields)
    with pytest.raises(FileError, match=r"contacts\.frame: found 5 to 5, expected 0 to 4"):
        Result.load(tmp_path / "r.npz")


def test_python_objects_are_never_read(tmp_path, saved):
    fields = dict(saved[0])
    fields["meta/names"] = np.array([{"a": 1}], dtype=object)
    np.savez(tmp_path / "r.npz", **fields)
    with pytest.raises(FileError, match="Python objects"):
        Result.load(tmp_path / "r.npz")


def test_other_files(tmp_path):
    with pytest.raises(FileError, match=r"nothing.npz: no such file"):
        Result.load(tmp_path / "nothing.npz")
    with pytest.raises(FileError, match="this is a folder"):
        Result.load(tmp_path)
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(FileError, match=r"not an .npz archive"):
        Result.load(tmp_path / "text.npz")


def test_nothing_is_left_where_it_cannot_be_written(tmp_path, body):
    with pytest.raises(FileError, match="does not exist"):
        make_result(body).save(tmp_path / "no" / "r.npz")
    assert not list(tmp_path.iterdir())


# -- in memory -----------------------------------------------------------------------------


def test_lengths_must_agree(body):
    with pytest.raises(InputError, match=r"found lengths .*'lost_time': 3.*expected 5"):
        make_result(body, lost_time=np.zeros(3))
    with pytest.raises(InputError, match=r"found lengths .*passes.*: 3.*expected 5"):
        make_result(body, diagnostics={"passes": np.zeros(3)})
    with pytest.raises(InputError, match="people: found none"):
        make_result(body, people=0)
    with pytest.raises(InputError, match="names: found"):
        make_result(body, names=("person0", "ball", "stick"))


def test_results_are_read_only(body):
    result = make_result(body)
    with pytest.raises(dataclasses.FrozenInstanceError):
        result.clearance = np.zeros(5)  # type: ignore[misc]
    for array in (result.clearance, result.contacts.impulse, result.objects["ball"].position):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_contacts_are_chosen_by_mask_and_index(body):
    contacts = make_result(body, seed=1).contacts
    assert len(contacts) > 3
    mask = np.arange(len(contacts)) % 2 == 0
    assert len(contacts[mask]) == mask.sum()
    np.testing.assert_array_equal(contacts[2].impulse, contacts.impulse[2:3])
    np.testing.assert_array_equal(contacts[1:3].part, contacts.part[1:3])


def test_free_frames(body):
    none = Contacts.none()
    at = np.array([10, 20])
    touching = dataclasses.replace(
        none,
        **{
            name: np.tile([0.0, 0.0, 1.0], (2, 1)) if name in VECTORS else np.zeros(2, dtype=int)
            for name in COLUMNS
        },
    )
    touching = dataclasses.replace(touching, frame=at)
    result = make_result(body, frames=40, contacts=touching)
    free = result.free_frames(settle=0.1)  # 3 frames at 29.97 fps
    expected = np.ones(40, dtype=bool)
    expected[10:14] = expected[20:24] = False
    np.testing.assert_array_equal(free, expected)
    with pytest.raises(InputError, match="person: found 1"):
        result.free_frames(1)


def test_summary_says_what_touched_what(body):
    result = make_result(body, contacts=Contacts.none())
    row = {
        name: np.array([[0.0, 3.0, 4.0]]) if name in VECTORS else np.zeros(1, dtype=int)
        for name in COLUMNS
    }
    row |= {"frame": np.array([2]), "part": np.array([20]), "other": np.array([1])}
    text = dataclasses.replace(result, contacts=Contacts(**row)).summary()
    assert "5 frames at 29.97 fps" in text
    assert "touched wall in 1 frames with left_wrist; hardest 5.00 N s" in text
    assert "touched" not in result.summary()
