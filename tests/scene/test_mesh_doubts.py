"""Warnings of meshes that seem to be read wrongly: who hears them, and who said how to read."""

from __future__ import annotations

import warnings

import pytest

import halfphysics as hp
from halfphysics.geometry.mesh_files import turned
from support.boxed_rooms import ROOMS, y_up
from support.command_line import run


def write_obj(path, mesh):
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    path.write_text("\n".join(lines))
    return str(path)


@pytest.fixture
def lying(tmp_path):
    """A room in centimetres with y up."""
    room = turned(y_up(ROOMS["open, about zero"]), scale=100.0, up="z")
    return write_obj(tmp_path / "room.obj", room)


def test_both_are_said_with_the_way_out(lying):
    with pytest.warns(hp.HalfPhysicsWarning) as said:
        hp.Scene().add_static("room", lying)
    unit, up = (str(one.message) for one in said)
    assert unit == (
        "static 'room': the mesh is 600 x 260 x 400 m; is it in centimetres? Then say scale=0.01"
    )
    assert up.startswith("static 'room': the mesh is read with z up, and its y axis is along")
    assert up.endswith("is y up? Then say up='y' (up='z': it is right)")


@pytest.mark.parametrize(
    ("options", "warnings_left"),
    [
        ({"scale": 0.01}, 1),
        ({"up": "y"}, 1),
        ({"scale": 0.01, "up": "y"}, 0),
        ({"scale": 0.01, "up": "z"}, 0),
        ({"quaternion": (0.7071, 0.7071, 0, 0)}, 1),
        ({"quaternion": (0.7071, 0.7071, 0, 0), "scale": 0.01}, 0),
    ],
)
def test_what_is_said_is_not_asked(options, warnings_left, lying):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        hp.Scene().add_static("room", lying, **options)
    assert len(said) == warnings_left


def test_a_saved_scene_asks_nothing(lying, tmp_path):
    scene = hp.Scene()
    with pytest.warns(hp.HalfPhysicsWarning):
        scene.add_static("room", lying)
    scene.save(tmp_path / "room.yaml")
    text = (tmp_path / "room.yaml").read_text()
    (tmp_path / "room.yaml").write_text(text.replace("scale: 1.0", "scale: 0.01"))
    hp.Scene.load(tmp_path / "room.yaml")  # up is in the file


@pytest.mark.parametrize("given", [["--static", "room=room.obj"], ["--scene", "room.yaml"]])
def test_the_command_line_says_it_in_its_words(given, lying, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.yaml").write_text("statics:\n  room: {mesh: room.obj}\n")
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # as in a separate program, not in this test run
        assert run("simulate", "no.npz", *given) == 2
        run("evaluate", "no.npz", *given)
    err = capsys.readouterr().err
    assert "Then say so: --static NAME=FILE,scale=0.01, or scale: 0.01 in" in err
    assert "Then say so: --static NAME=FILE,up=y, or up: y in the scene file (up z: it" in err
