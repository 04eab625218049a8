"""One-line items of the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Plane, Sphere
from halfphysics.scene.item_spec import parse_object, parse_static
from halfphysics.scene.scene import Scene


def test_the_example() -> None:
    name, shape, options = parse_object("ball=sphere:0.11,mass=0.43,position=1:0:0.11")
    assert (name, shape) == ("ball", Sphere(0.11))
    assert options == {"mass": 0.43, "position": (1.0, 0.0, 0.11)}
    ball = Scene().add_object(name, shape, **options)
    assert ball.position.tolist() == [1.0, 0.0, 0.11]


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("box:1:2:3", Box((1, 2, 3))),
        ("capsule:0.1:2", Capsule(0.1, 2)),
        ("cylinder:0.1:2e-1", Cylinder(0.1, 0.2)),
        ("plane", Plane()),
        ("meshes/chair.obj", "meshes/chair.obj"),
        ("C:\\room.GLB", "C:\\room.GLB"),
    ],
)
def test_every_shape(text: str, shape: object) -> None:
    assert parse_static(f"x = {text}") == ("x", shape, {})


def test_short_names_of_keys_go_on_working() -> None:
    long = parse_object("x=sphere:1,mass=1,position=1:2:3,quaternion=0:0:0:1")
    assert parse_object("x=sphere:1,mass=1,at=1:2:3,quat=0:0:0:1") == long


def test_every_key() -> None:
    _, _, options = parse_object(
        "x=a.obj,density=500, friction=.5,restitution=0.2,at=-1:2:+3,quat=0:0:0:1,"
        "velocity=1:0:0,scale=0.7,up=y"
    )
    assert options == {
        "density": 500.0,
        "friction": 0.5,
        "restitution": 0.2,
        "position": (-1.0, 2.0, 3.0),
        "quaternion": (0.0, 0.0, 0.0, 1.0),
        "velocity": (1.0, 0.0, 0.0),
        "scale": 0.7,
        "up": "y",
    }


def test_mesh_without_suffix_that_exists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "chair").write_text("")
    monkeypatch.chdir(tmp_path)
    assert parse_static("x=chair")[1] == "chair"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sphere:0.1,mass=1", r"object 'sphere:0.1,mass=1': expected NAME=SHAPE"),
        ("", "NAME=SHAPE"),
        ("=sphere:1,mass=1", "NAME=SHAPE"),
        ("x=,mass=1", "unknown shape ''"),
        ("x=spher:0.1,mass=1", r"unknown shape 'spher:0.1' \(did you mean sphere\?\)"),
        ("x=torus,mass=1", "expected plane, sphere:RADIUS, box:X:Y:Z"),
        ("x=sphere,mass=1", "expected sphere:RADIUS"),
        ("x=box:1:2,mass=1", "expected box:X:Y:Z"),
        ("x=sphere:big,mass=1", "expected sphere:RADIUS"),
        ("x=sphere:-1,mass=1", "radius: expected a number above 0"),
        ("x=sphere:nan,mass=1", "expected sphere:RADIUS"),
        ("x=sphere:1", "mass= .* or density= .*neither"),
        ("x=sphere:1,mass=1,density=1", "found both"),
        ("x=sphere:1,mass=1,mass=2", "mass is given twice"),
        ("x=sphere:1,mass", "mass has no value, expected mass=NUMBER"),
        ("x=sphere:1,mass=1,at=1:0", "at: found '1:0', expected at=NUMBER:NUMBER:NUMBER"),
        ("x=sphere:1,mass=1,quat=1", "quat: found '1', expected quat="),
        ("x=sphere:1,mass=1,up=x", "up: found 'x', expected y or z"),
        ("x=sphere:1,mass=1,at=1:0:0,position=1:0:0", "position is given twice"),
        ("x=sphere:1,mas=1", r"unknown key 'mas' \(did you mean mass\?\)"),
        ("x=sphere:1,mass=1,", "unknown key ''"),
    ],
)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_object(text)


def test_all_mistakes_in_one_message() -> None:
    with pytest.raises(InputError) as caught:
        parse_object("x=spher:1,mass=heavy,at=1,colour=red")
    message = str(caught.value)
    for part in ("spher:1", "found 'heavy'", "found '1'", "'colour'", "Example: ball=sphere:0.11"):
        assert part in message
    assert "neither" not in message


def test_statics_have_no_mass() -> None:
    with pytest.raises(InputError, match="unknown key 'mass'"):
        parse_static("x=sphere:1,mass=1")


def test_a_soft_material_is_a_word():
    assert parse_static("bed=box:2:1:0.4,soft=mattress")[2] == {"soft": "mattress"}
    assert parse_object("ball=sphere:0.1,mass=1,soft=pillow")[2]["soft"] == "pillow"
    with pytest.raises(InputError, match="soft: found 'stone', expected sofa or mattress or"):
        parse_static("bed=box:2:1:0.4,soft=stone")
