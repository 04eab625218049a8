"""Result files: exact round trip, readable as motions, free of licensed data."""

from __future__ import annotations

import dataclasses
import json
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Plane, Sphere
from halfphysics.motion.motion import Motion
from halfphysics.results.contacts import Contacts
from halfphysics.results.result import ObjectTrack, PersonResult, Result
from halfphysics.results.substeps import Substeps
from halfphysics.scene.scene import Scene
from support.results.random_result import assert_same, make_result


@pytest.fixture(scope="module")
def body():
    return Body.default()


@given(
    seed=st.integers(0, 2**32 - 1),
    people=st.integers(1, 3),
    frames=st.integers(2, 6),
    axes=st.sampled_from("zy"),
    model=st.sampled_from(["smplx", "smplh", "smpl"]),
    holds=st.integers(0, 2),
)
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_a_file_gives_back_every_bit(tmp_path, body, seed, people, frames, axes, model, holds):
    result = make_result(body, seed, people, frames, axes, model=model, holds=holds)
    path = tmp_path / "result.npz"
    result.save(path)
    loaded = Result.load(path)
    assert_same(result, loaded)
    assert loaded.holds == result.holds
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
    motion = Motion.load(tmp_path / "r.npz")
    # AMASS is z-up whatever the motion's source; rounding only, of numbers of size 1.
    np.testing.assert_allclose(
        body.joints(motion),
        body.joints(result.motion),
        rtol=0,
        atol=1e-14 if axes == "z" else 1e-13,
    )
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
        assert {k.split("/")[0] for k in others} == {
            "object",
            "contact",
            "inside",
            "breaches",
            "meta",
        }
        np.testing.assert_array_equal(file["object/ball/position"], result.objects["ball"].position)
        np.testing.assert_array_equal(file["contact/impulse"], result.contacts.impulse)


def test_keys_of_the_input_file_are_kept(tmp_path, body):
    rng = np.random.default_rng(1)
    upright = np.eye(1, 156) * np.pi / 2
    given = {
        "trans": rng.normal(size=(4, 3)).astype(np.float32) * 0.01,
        "poses": (upright + rng.normal(0, 0.01, size=(4, 156))).astype(np.float32),
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


@pytest.mark.parametrize("stature", [1.53, 1.70, 1.84, 1.90])
def test_another_shape_and_stature_come_back(tmp_path, stature):
    """To the last bit: the stature that was asked for, not that of the scaled skin."""
    body = Body.default(betas=[0.5, -1.0], stature=stature, mass=70.0)
    make_result(body).save(tmp_path / "r.npz")
    again = Result.load(tmp_path / "r.npz").people[0].body
    np.testing.assert_array_equal(again.rest_vertices, body.rest_vertices)
    np.testing.assert_array_equal(again.rest_joints, body.rest_joints)


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
    result = Result.load(tmp_path / "r.npz")  # no warning until the scene is used
    assert result.names == ("floor", "rock", "person0")
    with pytest.warns(HalfPhysicsWarning, match=r"rock \(.*tetra.obj is not there\).*scene="):
        assert list(result.scene.statics) == ["floor"]
    result.save(tmp_path / "again.npz")  # the reference is kept
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "r.npz").read_bytes()
    assert list(Result.load(tmp_path / "r.npz", scene=scene).scene.statics) == ["floor", "rock"]


def test_another_scene_has_names_of_the_result(tmp_path, body):
    scene = Scene()
    scene.add_static("floor", Plane())
    make_result(body, scene=scene).save(tmp_path / "r.npz")
    assert not Result.load(tmp_path / "r.npz", scene=Scene()).scene.statics
    other = Scene()
    other.add_static("rock", Plane())
    with pytest.raises(InputError, match=r"^scene: found static 'rock', .*static: 'floor'"):
        Result.load(tmp_path / "r.npz", scene=other)
    thrown = Scene()
    thrown.add_object("floor", Sphere(0.1), mass=1.0)  # static in the result
    with pytest.raises(InputError, match=r"found object 'floor', .*objects: none"):
        Result.load(tmp_path / "r.npz", scene=thrown)


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
    from halfphysics.body import body as module

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
    with pytest.raises(InputError, match="found 3 bodies, expected 2"):
        Result.load(tmp_path / "r.npz", body=[body] * 3)


def test_other_things_than_bodies_scenes_and_paths(tmp_path, body):
    make_result(body).save(tmp_path / "r.npz")
    for wrong in ("body.npz", 3, [None], Body):
        with pytest.raises(InputError, match=r"^body: found .*expected a halfphysics\.Body"):
            Result.load(tmp_path / "r.npz", body=wrong)
    with pytest.raises(InputError, match=r"^scene: found 'room', expected a halfphysics\.Scene"):
        Result.load(tmp_path / "r.npz", scene="room")
    with pytest.raises(InputError, match="path: expected the path of a file"):
        Result.load(123)
