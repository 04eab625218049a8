"""halfphysics evaluate: what it refuses, before it measures."""

from __future__ import annotations

import re

import pytest

import halfphysics as hp
from support.command_line import run
from support.people import along_x


def room(names=("box",)):
    scene = hp.Scene()
    for place, name in enumerate(names):
        scene.add_static(name, hp.Box((1.0, 1.0, 1.0)), position=(9.0, 2.0 * place, 0.5))
    return scene


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evaluate")
    motion = along_x(0.3, 6, 0.0, z=1.2)
    motion.save(folder / "walk.npz")
    hp.simulate(motion, room(), settings=hp.Settings(contact="parts")).save(folder / "r.npz")
    room().save(folder / "room.json")
    room(["box", "chest", "lamp"]).save(folder / "other.json")
    return folder


@pytest.fixture
def folder(made, monkeypatch):
    """The working folder: walk.npz, its result r.npz, the scene room.json and another."""
    monkeypatch.chdir(made)
    return made


@pytest.mark.parametrize(
    "words",
    [
        ["--json", "room.json", "--scene", "room.json"],
        ["--json", "walk.npz", "--body", "walk.npz"],
        ["--json", "walk.npz", "--model", "walk.npz"],
        ["--json", "walk.npz", "--reference", "walk.npz"],
        ["--json", "r.npz"],
    ],
)
def test_no_input_is_written_over(words, folder, capsys):
    path = folder / words[1]
    before = path.read_bytes()
    assert run("evaluate", "r.npz", *words) == 2
    assert f"{words[1]}: this is the input" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_a_scene_with_other_names_is_refused_by_name(folder, capsys):
    assert run("evaluate", "r.npz", "--scene", "other.json") == 2
    err = capsys.readouterr().err
    assert "--scene: found static 'chest', 'lamp', which r.npz does not have" in err
    assert "static: 'box'; objects: none" in err


def test_a_scene_of_a_result_gets_a_floor_where_the_result_has_one(folder, capsys):
    assert run("evaluate", "r.npz", "--scene", "room.json") == 0
    assert capsys.readouterr().out
    simulate = ("simulate", "walk.npz", "--scene", "room.json", "--contact", "parts")
    assert run(*simulate, "--out", "floor.npz") == 0
    assert run("evaluate", "floor.npz", "--scene", "room.json") == 0


@pytest.mark.parametrize("words", [["--frames", "0:3"], ["--fps", "99"], ["--up", "y"]])
def test_options_of_motion_files_are_refused_for_a_result(words, folder, capsys):
    assert run("evaluate", "r.npz", *words) == 2
    assert re.search(r"r\.npz: a result has its own frames", capsys.readouterr().err)
