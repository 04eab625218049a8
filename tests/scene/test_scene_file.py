"""Scene files: their contents, the place of every mistake, and writing them back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

import halfphysics as hp
from halfphysics.base import document_tree
from halfphysics.errors import FileError, HalfPhysicsWarning, InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane, Sphere
from halfphysics.scene.scene import Scene
from halfphysics.scene.scene_writer import scene_document
from support.paths import DOCS

WHOLE = """\
version: 1
gravity: 9.81
statics:
  floor: {shape: plane}
  wall:
    shape: box
    size: [0.1, 2, 2.5]
    position: [1, 0, 1.25]
    quaternion: [1, 0, 0, 1]
    friction: 0.9
objects:
  ball:
    shape: sphere
    radius: 0.11
    mass: 0.43
    friction: 6e-1
    restitution: 0.2
    position: [1, 0, 0.11]
    velocity: [0, 1, 0]
  can: {shape: cylinder, radius: 0.03, length: 0.12, density: 1000, com: [0, 0, -0.01]}
friction:
  - [ball, floor, 0.3]
ignore:
  - [can, person]
"""


def _write(folder: Path, text: str, name: str = "room.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_a_whole_file(tmp_path: Path) -> None:
    scene = Scene.load(_write(tmp_path, WHOLE))
    assert list(scene.statics) == ["floor", "wall"]
    wall, ball, can = scene.statics["wall"], scene.objects["ball"], scene.objects["can"]
    assert wall.shape == Box((0.1, 2, 2.5))
    np.testing.assert_allclose(wall.quaternion, np.sqrt([0.5, 0, 0, 0.5]))
    assert (wall.friction, ball.friction, can.friction) == (0.9, 0.6, 0.8)
    assert (ball.mass, ball.restitution) == (0.43, 0.2)
    np.testing.assert_array_equal(ball.velocity, [0, 1, 0])
    assert can.mass == pytest.approx(1000 * np.pi * 0.03**2 * 0.12)
    np.testing.assert_array_equal(can.com, [0, 0, -0.01])
    assert scene.friction_of("floor", "ball") == 0.3
    assert scene.ignores("person", "can")
    assert not Scene.load(_write(tmp_path, "statics:\nobjects: {}\n")).statics


def test_json_says_the_same_with_tabs_too(tmp_path: Path) -> None:
    import yaml

    document = yaml.safe_load(WHOLE.replace("6e-1", "0.6"))
    for indent in (None, 2, "\t"):
        path = _write(tmp_path, json.dumps(document, indent=indent), "room.json")
        assert scene_document(Scene.load(path)) == scene_document(
            Scene.load(_write(tmp_path, WHOLE))
        )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "friction: 6e-1",
            "frictoin: 6e-1",
            r"line 16, objects.ball.frictoin: unknown key 'frictoin' for a sphere; "
            "did you mean friction[?] Allowed: shape, radius, mass",
        ),
        ("gravity: 9.81", "gravty: 9.81", "line 2, gravty: .*did you mean gravity"),
        ("gravity: 9.81", "gravity: -9.81", "line 2, gravity: Scene: gravity"),
        ("gravity: 9.81", "gravity: [0, 1]", "a list of 3 numbers, found a list of 2"),
        ("version: 1", "version: 7", "found version 7, expected 1"),
        ("statics:", "static:", "did you mean statics"),
        ("radius: 0.11", "radius: wide", "line 14, objects.ball.radius: .*number, found 'wide'"),
        ("radius: 0.11", "radius: -1", "line 12, objects.ball: Sphere: radius"),
        ("radius: 0.11", "radius: .nan", "finite number"),
        ("radius: 0.11", f"radius: 1{'0' * 400}", "finite number, found 1000"),
        ("radius: 0.11", "radius: true", "number, found True"),
        ("radius: 0.11", "radius:", "number, found nothing"),
        ("radius: 0.11", "radius: 1:30", "number, found '1:30'"),
        ("    radius: 0.11\n", "", "line 12, objects.ball: a sphere needs radius"),
        ("radius: 0.11", "radius: 0.1\n    radius: 0.2", "line 15.*twice, first in line 14"),
        ("radius: 0.11", "size: [1, 1, 1]", "unknown key 'size' for a sphere"),
        ("mass: 0.43", "mass: -1", "objects.ball: object 'ball': mass: .*above 0.*found -1"),
        ("mass: 0.43", "restitutoin: 1", "did you mean restitution"),
        ("    mass: 0.43\n", "", "mass= .* or density="),
        ("mass: 0.43", "mass: 1\n    density: 3", "found both"),
        ("shape: sphere", "shape: spheer", "line 13, objects.ball.shape: .*did you mean sphere"),
        ("    shape: sphere\n", "", "expected shape .* or mesh .*neither"),
        ("shape: sphere", "shape: sphere\n    mesh: a.obj", "found both"),
        ("size: [0.1, 2, 2.5]", "size: 3", r"statics.wall.size: expected a list of 3 numbers"),
        ("size: [0.1, 2, 2.5]", "size: [0.1, 2, x]", r"statics.wall.size\[2\]: .*'x'"),
        ("position: [1, 0, 1.25]", "position: {x: 1}", r"found a mapping \(x\)"),
        ("quaternion: [1, 0, 0, 1]", "quaternion: [0, 0, 0, 0]", "zero length"),
        ("friction: 0.9", "mass: 3", "unknown key 'mass' for a box"),
        ("ball, floor, 0.3", "bal, floor, 0.3", r"line 22, friction\[0\]: .*did you mean 'ball'"),
        ("[ball, floor, 0.3]", "[ball, floor]", r"expected \[name, name, coefficient\]"),
        ("can, person", "can, 3", r"ignore\[0\]\[1\]: expected text, found 3"),
        ("  can:", "  floor:", "objects.floor: object 'floor': .*already"),
        ("  can:", "  no:", "key 'no' that is not text; put it in quotes"),
        ("  can: {", "  can: [", "line 20.*not valid YAML"),
        (
            "  floor: {shape: plane}",
            "  floor: plane",
            "statics.floor: expected a mapping .*shape or mesh",
        ),
        (WHOLE, "", "the file is empty"),
        (WHOLE, "- 1\n", "expected a mapping"),
        (WHOLE, "x: &a [*a]\n", "nested too deeply|not valid YAML|unknown key"),
        # PyYAML from 6.0.4 stops at its own bound, before ours.
        (WHOLE, "a: " + "[" * 3000 + "]" * 3000, "nested too deeply|maximum nesting depth"),
        (WHOLE, "!!python/object/apply:os.system ['true']", "expected a mapping"),
    ],
)
def test_mistakes_name_their_place(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in WHOLE
    path = _write(tmp_path, WHOLE.replace(old, new))
    with pytest.raises(FileError, match=message) as caught:
        Scene.load(path)
    assert str(caught.value).startswith(str(path))


def test_json_mistakes(tmp_path: Path) -> None:
    path = _write(tmp_path, '{\n "statics": {,}\n}', "room.json")
    with pytest.raises(FileError, match=r"room.json, line 2: not valid JSON"):
        Scene.load(path)
    path = _write(tmp_path, '{\n\t"statics": {\n\t\t"a": {"shpe": "plane"}}}', "room.json")
    with pytest.raises(FileError, match=r"line 3, statics.a.shpe: .*did you mean shape"):
        Scene.load(path)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        Scene.load(tmp_path / "room.yaml")
    with pytest.raises(FileError, match=r"suffix '.glb', expected a scene file .*add_static"):
        Scene.load(_write(tmp_path, "", "room.glb"))
    (tmp_path / "b.yaml").write_bytes(b"\xff\xfe\x00a")
    with pytest.raises(FileError, match="not a text file"):
        Scene.load(tmp_path / "b.yaml")


def _box_file(folder: Path) -> Path:
    trimesh = pytest.importorskip("trimesh")
    folder.mkdir(exist_ok=True)
    path = folder / "box.ply"
    trimesh.creation.box((1.0, 2.0, 3.0)).export(path)
    return path


def test_mesh_paths_are_relative_to_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = _box_file(tmp_path / "meshes")
    path = _write(tmp_path, "statics: {m: {mesh: meshes/box.ply, scale: 0.1, up: y}}")
    monkeypatch.chdir("/")
    static = Scene.load(path).statics["m"]
    np.testing.assert_allclose(np.ptp(static.mesh()[0], axis=0), [0.1, 0.3, 0.2])
    assert static.source is not None
    assert static.source.path == str(mesh.resolve())
    path = _write(tmp_path, "statics:\n  m: {mesh: meshes/bax.ply}")
    with pytest.raises(FileError, match=r"line 2, statics.m.mesh: .*did you mean .*box\.ply"):
        Scene.load(path)
    path = _write(tmp_path, "statics:\n  m: {mesh: meshes/box.ply, radius: 1}")
    with pytest.raises(FileError, match="unknown key 'radius' for a mesh"):
        Scene.load(path)


def test_a_changed_mesh_is_noticed(tmp_path: Path) -> None:
    mesh = _box_file(tmp_path)
    scene = Scene()
    scene.add_static("m", mesh)
    path = tmp_path / "room.yaml"
    scene.save(path)
    Scene.load(path)
    pytest.importorskip("trimesh").creation.box((1.0, 2.0, 3.1)).export(mesh)
    with pytest.warns(HalfPhysicsWarning, match=r"statics.m.sha256: .* has changed") as got:
        Scene.load(path)
    assert [warning.filename for warning in got] == [__file__]


def _everything(folder: Path) -> Scene:
    scene = Scene(gravity=(0.1, -0.2, -9.7))
    scene.add_static("floor", Plane((0, 0.1, 1), 0.02), restitution=0.25)
    scene.add_static("file", _box_file(folder / "m"), scale=0.3, up="y", quaternion=(1, 2, 3, 4))
    scene.add_static("pole", Capsule(0.1, 2), position=(1e-7, 2, 1 / 3), friction=0.123456789)
    scene.add_object("ball", Sphere(0.11), mass=0.43, velocity=(1, 2, 3))
    scene.add_object("box", Box((0.1, 0.2, 0.3)), density=700, angular_velocity=(0, 0, 1))
    scene.add_object("can", Cylinder(0.1, 0.3), mass=1, com=(0, 0, 0.1))
    scene.add_object("crate", folder / "m" / "box.ply", density=30, scale=0.1)
    v, f = Box((0.3, 0.3, 0.3)).triangles()
    scene.add_object("inline", Mesh(v + 0.1, f), mass=2)
    scene.friction("ball", "floor", 0.35)
    scene.friction("person", "person", 0.5)
    scene.ignore("box", "can")
    return scene


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_names_like_numbers_and_emoji_survive_saving(tmp_path: Path, suffix: str) -> None:
    names = ["1e3", "-.5E-3", "010", "08", "null", "\U0001f600"]
    scene = Scene()
    for name in names:
        scene.add_static(name, Box((1.0, 1.0, 1.0)))
    scene.save(tmp_path / f"room{suffix}")
    assert list(Scene.load(tmp_path / f"room{suffix}").statics) == names


@pytest.mark.parametrize("name", ["room.yaml", "room.yml", "room.json"])
def test_saving_and_loading_gives_the_same_scene(tmp_path: Path, name: str) -> None:
    scene = _everything(tmp_path)
    folder = tmp_path / "scenes"
    folder.mkdir()
    scene.save(folder / name)
    again = Scene.load(folder / name)
    np.testing.assert_array_equal(again.gravity, scene.gravity)
    assert (again.friction_pairs, again.ignored_pairs) == (
        scene.friction_pairs,
        scene.ignored_pairs,
    )
    for mine, theirs in ((scene.statics, again.statics), (scene.objects, again.objects)):
        assert list(mine) == list(theirs)
        for a, b in zip(mine.values(), theirs.values(), strict=True):
            assert vars(a).keys() == vars(b).keys()
            for key, value in vars(a).items():
                other = getattr(b, key)
                if isinstance(value, Mesh):
                    np.testing.assert_array_equal(value.vertices, other.vertices)
                    np.testing.assert_array_equal(value.faces, other.faces)
                elif isinstance(value, np.ndarray):
                    np.testing.assert_array_equal(value, other, err_msg=f"{a.name}.{key}")
                else:
                    assert value == other
    again.save(folder / f"again-{name}")
    assert (folder / f"again-{name}").read_bytes() == (folder / name).read_bytes()
    text = (folder / name).read_text()
    assert "../m/box.ply" in text
    assert str(tmp_path) not in text


def test_saving_fails_whole(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"suffix '.toml'"):
        Scene().save(tmp_path / "room.toml")
    with pytest.raises(FileError, match="does not exist"):
        Scene().save(tmp_path / "nowhere" / "room.yaml")
    assert not list(tmp_path.iterdir())


def test_the_documented_example_loads(tmp_path: Path) -> None:
    import re

    page = (DOCS / "scene-files.md").read_text()
    example = re.search(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert example is not None
    _box_file(tmp_path)
    (tmp_path / "box.ply").rename(tmp_path / "room.ply")
    scene = Scene.load(_write(tmp_path, example[1]))
    assert "ball" in scene.objects
    for key in ("version", "gravity", "statics", "objects", "friction", "ignore"):
        assert f"`{key}`" in page


def test_long_json_is_the_same_scene_and_as_strict(tmp_path: Path) -> None:
    """From a quarter of a million letters on it is read without the lines of its values."""
    rows = np.random.default_rng(0).normal(size=(6_000, 3)).tolist()
    moving = {"shape": "sphere", "radius": 1, "fps": 30, "positions": rows}
    text = json.dumps({"moving": {"a": moving}})
    assert len(text) > 2**18
    scene = Scene.load(_write(tmp_path, text, "long.json"))
    np.testing.assert_array_equal(scene.objects["a"].positions, rows)
    for old, new, message in (
        ('"radius": 1', '"radius": 1, "radius": 2', "key 'radius' is given twice"),
        ('"radius": 1', '"radus": 1', "unknown key 'radus'"),
        ('"radius": 1', '"radius": ' + "[" * 30 + "]" * 30, "nested too deeply"),
        ('"radius": 1', '"radius": ' + "1" * 9_000, "not valid JSON"),
    ):
        with pytest.raises(FileError, match=message):
            Scene.load(_write(tmp_path, text.replace(old, new), "long.json"))


def test_files_far_too_long_are_not_read(tmp_path: Path) -> None:
    for name, most in (("a.json", 16), ("a.yaml", 4)):
        with (tmp_path / name).open("wb") as handle:
            handle.truncate(most * 2**20 + 1)
        with pytest.raises(FileError, match=f"{most}.0 MiB of text, expected at most {most}"):
            Scene.load(tmp_path / name)


def test_what_would_be_too_long_to_be_read_is_not_written(tmp_path: Path, monkeypatch) -> None:
    """And what is there stays."""
    scene = Scene()
    scene.add_static("ball", trimesh.creation.icosphere(subdivisions=3))
    path = tmp_path / "scene.json"
    scene.save(path)
    size = path.stat().st_size
    monkeypatch.setitem(document_tree._MOST_BYTES, ".json", size - 1)
    with pytest.raises(FileError, match=r"meshes into files of their own$"):
        scene.save(path)
    monkeypatch.setitem(document_tree._MOST_BYTES, ".json", size)
    monkeypatch.setattr(document_tree, "_MOST_VALUES", 100)
    with pytest.raises(FileError, match="more than 100 values"):
        scene.save(path)
    monkeypatch.undo()
    assert path.stat().st_size == size
    np.testing.assert_array_equal(
        Scene.load(path).statics["ball"].shape.vertices, scene.statics["ball"].shape.vertices
    )


def test_soft_layers_come_back(tmp_path):
    scene = hp.Scene()
    scene.add_static("bed", hp.Box((2.0, 1.0, 0.4)), soft="mattress")
    scene.add_static("mat", hp.Plane(), soft=hp.Soft(0.05, 3e5, law="linear"))
    scene.add_object("ball", hp.Sphere(0.1), mass=1.0, soft=hp.Soft(0.03, 1e5, recovery=2.0))
    for name in ("scene.yaml", "scene.json"):
        scene.save(tmp_path / name)
        again = hp.Scene.load(tmp_path / name)
        assert {n: s.soft for n, s in again.statics.items()} == {
            n: s.soft for n, s in scene.statics.items()
        }
        assert again.objects["ball"].soft == scene.objects["ball"].soft


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        ("soffa", "no material called 'soffa'; did you mean 'sofa'?"),
        ("{thicknes: 0.1}", "unknown key 'thicknes' for a soft layer; did you mean thickness?"),
        ("{thickness: 0.1}", "found no stiffness"),
        ("{material: sofa, thickness: -1}", "expected a number from 0.002 to 2 [m], found -1"),
        ("{thickness: 0.6, stiffness: 100000}", "thickness is 0.6 m; expected at most 0.45 m"),
        ("3", "expected text, found 3"),
    ],
)
def test_mistakes_in_soft_layers_are_named_with_their_line(tmp_path, layer, words):
    path = tmp_path / "scene.yaml"
    path.write_text(f"statics:\n  x: {{shape: box, size: [1, 1, 1], soft: {layer}}}\n")
    with pytest.raises(FileError) as caught:
        hp.Scene.load(path)
    assert f"{path}, line 2, statics.x" in str(caught.value)
    assert words in str(caught.value)
