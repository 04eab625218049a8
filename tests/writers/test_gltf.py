"""glTF files agree with the take: vertices of people and objects, by an independent reader."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import halfphysics as hp
from halfphysics.body.body import Body
from halfphysics.motion.skeleton import JOINT_NAMES
from halfphysics.render.look import BODIES, OBJECTS
from halfphysics.results.result import ObjectTrack
from halfphysics.writers.take import take_of
from support.files.gltf_reader import Gltf
from support.people import along_x, violent
from support.results.gltf_results import many_handed, y_up
from support.results.random_result import make_result

#: Single precision along a chain of ten joints, a few metres from the origin [m].
TOLERANCE = 2e-6


def five(frames):
    return sorted({round(f) for f in np.linspace(0, frames - 1, 5)})


def assert_shows(path, take, tolerance=TOLERANCE):
    """Every vertex of every person and object is in the file where the take has it."""
    file = Gltf(path)
    file.check()
    np.testing.assert_allclose(file.times, np.arange(take.frames) / take.fps, rtol=1e-6)
    for frame in five(take.frames):
        time = float(file.times[frame])
        for actor in take.actors:
            ours = y_up(actor.body.vertices(actor.motion, frame))
            theirs = file.vertices(f"{actor.name}_skin", time)
            assert np.abs(theirs - ours).max() < tolerance
        for prop in take.props:
            k = frame if prop.moves else 0
            q = prop.quaternion[k]
            turn = Rotation.from_quat([*q[1:], q[0]])  # scipy: of any length
            ours = y_up(turn.apply(prop.vertices[prop.faces].reshape(-1, 3)) + prop.position[k])
            node = file.json["nodes"][file.node(prop.name)]
            corners = file.json["meshes"][node["mesh"]]["primitives"][0]["indices"]
            theirs = file.vertices(prop.name, time)[file.array(corners)]
            assert np.abs(theirs - ours).max() < tolerance
    return file


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_violent_motion_of_one_person(tmp_path, suffix):
    motion = violent(60)
    path = tmp_path / f"violent{suffix}"
    hp.export(motion, path)
    file = assert_shows(path, take_of(motion))
    names = [file.json["nodes"][j]["name"] for j in file.json["skins"][0]["joints"]]
    assert tuple(names) == JOINT_NAMES


def test_a_real_clip(tmp_path, shared_data):
    motion = hp.Motion.load(sorted((shared_data / "motion").glob("*.npz"))[0])
    body = Body.default(stature=1.6)
    hp.export(motion, tmp_path / "clip.glb", body=body)
    assert_shows(tmp_path / "clip.glb", take_of(motion, body))


def test_between_frames_it_turns_the_short_way(tmp_path):
    """Between two frames as a motion resampled to twice the rate (half turns included)."""
    motion = violent(40)
    hp.export(motion, tmp_path / "once.glb")
    file, double = Gltf(tmp_path / "once.glb"), motion.resample(2 * motion.fps)
    body = Body.default()
    for frame in (1, 17, 33, 61):
        theirs = file.vertices("person_skin", frame / double.fps)
        assert np.abs(theirs - y_up(body.vertices(double, frame))).max() < 2e-5


def test_several_people_and_things(tmp_path):
    result = make_result(Body.default(), people=3, frames=7, axes="y")
    hp.export(result, tmp_path / "result.glb")
    file = assert_shows(tmp_path / "result.glb", take_of(result))
    # The body of all three is stored once.
    first, *others = (m["primitives"][0] for m in file.json["meshes"][:3])
    for other in others:
        assert other["attributes"] == first["attributes"]
        assert other["indices"] == first["indices"]


def test_a_sequence_has_its_objects_as_recorded(tmp_path):
    motion = along_x(1.0, 12, 0.0)
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("cup", hp.Cylinder(0.04, 0.1), mass=0.2, position=(1.0, 0.0, 1.0))
    scene.add_object("left", hp.Box((0.1, 0.2, 0.3)), mass=0.2, position=(2.0, 0.0, 1.0))
    rng = np.random.default_rng(0)
    turns = rng.normal(size=(12, 4))
    recorded = {"cup": ObjectTrack(position=rng.normal(size=(12, 3)), quaternion=turns)}
    tall = Body.default(stature=1.9)
    sequence = hp.Sequence(motion, scene, body=tall, recorded=recorded)
    hp.export(sequence, tmp_path / "sequence.glb")
    file = assert_shows(tmp_path / "sequence.glb", take_of(sequence))
    animated = {c["target"]["node"] for c in file.json["animations"][0]["channels"]}
    assert file.node("cup") in animated
    assert file.node("left") not in animated


DRAWER = """
<mujoco><worldbody><body name="case"><geom type="box" size=".3 .3 .3"/>
<body name="drawer" pos="0 0 .1"><joint name="slide" type="slide" axis="1 0 0"/>
<geom type="box" size=".2 .2 .1"/><geom type="sphere" size=".03" pos=".25 0 0"/>
</body></body></worldbody></mujoco>"""


def test_links_of_articulated_things(tmp_path):
    scene = hp.Scene()
    scene.add_articulated("desk", DRAWER, position=(1.0, 0.5, 0.3))
    rng = np.random.default_rng(1)
    names = ("desk/case", "desk/drawer")
    tracks = {
        name: ObjectTrack(position=rng.normal(size=(5, 3)), quaternion=rng.normal(size=(5, 4)))
        for name in names
    }
    result = make_result(Body.default(), scene=scene, objects=tracks, names=(*names, "person0"))
    take = take_of(result)
    assert [p.name for p in take.props] == list(names)
    hp.export(result, tmp_path / "desk.glb")
    assert_shows(tmp_path / "desk.glb", take)


def test_links_that_nothing_was_recorded_of_stand_where_they_start(tmp_path):
    scene = hp.Scene()
    scene.add_articulated("desk", DRAWER, position=(1.0, 0.5, 0.3), joints={"slide": 0.25})
    sequence = hp.Sequence(along_x(1.0, 3, 0.0), scene)
    hp.export(sequence, tmp_path / "desk.glb")
    file = assert_shows(tmp_path / "desk.glb", take_of(sequence))
    middle = file.globals(0.0)[file.node("desk/drawer"), :3, 3]
    np.testing.assert_allclose(middle, y_up(np.array([1.25, 0.5, 0.4])), atol=1e-6)


def test_a_plane_is_drawn_where_the_story_is(tmp_path):
    """20 m of the plane around the person, at any distance; tilted ones stay in their plane."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane(offset=0.5))
    turn = [np.cos(0.2), np.sin(0.2), 0.0, 0.0]
    scene.add_static("ramp", hp.Plane(), position=(3.0, 1.0, 0.0), quaternion=turn)
    motion = along_x(1.0, 3, 400.0)
    hp.export(hp.Sequence(motion, scene), tmp_path / "far.glb")
    file = Gltf(tmp_path / "far.glb")
    person = y_up(Body.default().joints(motion)[:, 0].mean(axis=0))
    floor, ramp = file.vertices("floor", 0.0), file.vertices("ramp", 0.0)
    np.testing.assert_allclose(floor[:, 1], 0.5, atol=1e-6)
    np.testing.assert_allclose(np.ptp(floor, axis=0), [20.0, 0.0, 20.0], atol=1e-4)
    np.testing.assert_allclose(floor.mean(axis=0)[[0, 2]], person[[0, 2]], atol=0.05)
    up = y_up(np.array([0.0, -np.sin(0.4), np.cos(0.4)]))
    offset = up @ y_up(np.array([3.0, 1.0, 0.0]))
    np.testing.assert_allclose(ramp @ up, offset, atol=1e-4)
    foot = person - up * (up @ person - offset)
    np.testing.assert_allclose(ramp.mean(axis=0), foot, atol=0.05)


def test_people_and_things_of_other_lengths_are_refused(tmp_path):
    scene = hp.Scene()
    scene.add_object("cup", hp.Sphere(0.1), mass=1.0)
    one, other = along_x(1.0, 12, 0.0), along_x(1.0, 11, 2.0)
    track = ObjectTrack(position=np.zeros((5, 3)), quaternion=np.tile([1.0, 0, 0, 0], (5, 1)))
    for sequence, message in (
        (hp.Sequence((one, other), scene), "person1 has 11 frames at 30 fps, person0 has 12 at 30"),
        (hp.Sequence((one, one.resample(60.0)[:12]), scene), "person1 has 12 frames at 60 fps"),
        (hp.Sequence(one, scene, recorded={"cup": track}), "cup has 5 frames, expected 12"),
    ):
        with pytest.raises(hp.errors.InputError, match=message):
            hp.export(sequence, tmp_path / "a.glb")
    assert not list(tmp_path.iterdir())


def test_up_to_eight_joints_a_vertex(tmp_path):
    motion, body = violent(5), many_handed(7)
    hp.export(motion, tmp_path / "seven.glb", body=body)
    file = assert_shows(tmp_path / "seven.glb", take_of(motion, body))
    assert {"JOINTS_0", "JOINTS_1"} <= set(file.json["meshes"][0]["primitives"][0]["attributes"])


@pytest.mark.slow
def test_pose_blend_shapes_are_morph_targets(tmp_path):
    motion, body = violent(40), many_handed(4, posedirs=5e-3)
    hp.export(motion, tmp_path / "shapes.glb", body=body)
    file = assert_shows(tmp_path / "shapes.glb", take_of(motion, body), 1e-5)
    targets = file.json["meshes"][0]["primitives"][0]["targets"]
    assert 5 < len(targets) < 40  # fewer than the frames
    plain = dataclasses.replace(body, posedirs=None)
    gap = body.vertices(motion, 7) - plain.vertices(motion, 7)
    assert np.abs(gap).max() > 1e-2  # the difference is large


def test_a_person_who_holds_still(tmp_path):
    """Constant channels are left out but one, which says how long; nodes hold the pose, shapes of
    the pose included."""
    moving = violent(3)
    still = hp.Motion(moving.translation[[1, 1]], moving.rotations[[1, 1]], 30.0)
    body = many_handed(4, posedirs=1e-3)
    hp.export(still, tmp_path / "still.glb", body=body)
    file = Gltf(tmp_path / "still.glb")
    file.check()
    assert len(file.json["animations"][0]["channels"]) == 1
    theirs = file.vertices("person_skin", 0.0)
    assert np.abs(theirs - y_up(body.vertices(still, 0))).max() < 1e-5


def test_another_frame_rate(tmp_path):
    result = make_result(Body.default(), frames=6)
    hp.export(result, tmp_path / "fast.glb", fps=60.0)
    file = assert_shows(tmp_path / "fast.glb", take_of(result, fps=60.0))
    assert file.json["animations"][0]["extras"] == {"fps": 60.0}


def test_ten_seconds_of_a_person_are_small(tmp_path):
    """Skin 0.77 MB, and 16 bytes for every joint and frame; resting hands add no bytes."""
    hp.export(violent(300), tmp_path / "all.glb")
    assert (tmp_path / "all.glb").stat().st_size < 1_100_000
    motion = violent(300)
    rotations = motion.rotations.copy()
    rotations[:, 22:] = 0.0
    hp.export(motion.with_frames(motion.translation, rotations), tmp_path / "body.glb")
    saved = (tmp_path / "all.glb").stat().st_size - (tmp_path / "body.glb").stat().st_size
    assert saved > 33 * 300 * 16


def test_colors_are_those_of_the_pictures(tmp_path):
    result = make_result(Body.default(), people=2)
    hp.export(result, tmp_path / "r.glb")
    materials = {m["name"]: m for m in Gltf(tmp_path / "r.glb").json["materials"]}
    expected = {"person0": BODIES[0], "person1": BODIES[1], "ball": OBJECTS[0]}
    for name, color in expected.items():
        light = np.array(materials[name]["pbrMetallicRoughness"]["baseColorFactor"])
        shown = 1.055 * light[:3] ** (1 / 2.4) - 0.055  # sRGB, IEC 61966-2-1
        np.testing.assert_allclose(shown, color, atol=1e-3)


def test_trimesh_opens_it(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    result = make_result(Body.default(), frames=4)
    hp.export(result, tmp_path / "r.glb")
    scene = trimesh.load(tmp_path / "r.glb", force="scene")
    body = Body.default()
    skin = scene.geometry["person0_skin"]
    assert np.abs(skin.vertices - body.rest_vertices).max() < 1e-6
    np.testing.assert_array_equal(skin.faces, body.faces)
    matrix, _ = scene.graph.get("ball")  # an object is at its start
    np.testing.assert_allclose(matrix[:3, 3], y_up(result.objects["ball"].position[0]), atol=1e-6)


def test_the_command_line_writes_the_same_bytes(tmp_path, monkeypatch, capsys):
    from halfphysics.cli import main

    result = make_result(Body.default(), people=2)
    result.save(tmp_path / "result.npz")
    along_x(1.0, 8, 0.0).save(tmp_path / "walk.npz")
    monkeypatch.chdir(tmp_path)
    for source, target in (("result.npz", "a.glb"), ("walk.npz", "b.glb"), ("walk.npz", "c.gltf")):
        assert main(["convert", source, target]) == 0
        assert capsys.readouterr().out.endswith(f"written: {target}\n")
    hp.export(hp.Result.load("result.npz"), "a_too.glb")
    hp.export(hp.Motion.load("walk.npz"), "b_too.glb")
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "a_too.glb").read_bytes()
    assert (tmp_path / "b.glb").read_bytes() == (tmp_path / "b_too.glb").read_bytes()
    assert main(["convert", "walk.npz", "d.glb", "--to-fps", "60", "--stature", "1.5"]) == 0
    file = assert_shows(
        tmp_path / "d.glb", take_of(hp.Motion.load("walk.npz"), Body.default(stature=1.5), fps=60.0)
    )
    assert len(file.times) == 15


def test_only_known_suffixes(tmp_path):
    with pytest.raises(hp.errors.InputError, match=r"found suffix '\.fbx', expected one of \.glb"):
        hp.export(violent(3), tmp_path / "a.fbx")
    with pytest.raises(hp.errors.FileError, match="does not exist"):
        hp.export(violent(3), tmp_path / "nowhere" / "a.glb")
    assert not list(tmp_path.iterdir())


def test_a_person_who_stands_still_comes_back(tmp_path):
    still = along_x(0.0, 40, 0.0).grounded(Body.default())
    hp.export(still, tmp_path / "a.glb")
    again = hp.Motion.load(tmp_path / "a.glb")
    assert (len(again), again.fps) == (40, 30.0)
