"""halfphysics pressure: the files that it writes, and its messages for mistakes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

from halfphysics.cli import main
from support.results.soft_results import soft_result


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    path = tmp_path_factory.mktemp("pressure") / "bed.npz"
    soft_result().save(path)
    return path


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def run(*arguments):
    return main(["pressure", *map(str, arguments)])


def test_a_picture_of_the_thing_that_is_pressed_most(source, capsys):
    assert run(source, "-o", "map.png", "--cell", "2") == 0
    out = capsys.readouterr().out
    assert out.startswith("bed, top: up to 2.")
    assert out.endswith("pressure: map.png\n")
    with Image.open("map.png") as image:
        assert min(image.size) > 300


def test_arrays_of_a_thing_and_of_a_skin(source):
    assert run(source, "-o", "map.npz", "--of", "bed", "--side", "top", "--cell", "5") == 0
    with np.load("map.npz") as kept:
        rows, columns = kept["pressure"].shape[1:]
        # The bed, and what is spread over its border.
        assert 24 <= rows < 30
        assert 40 <= columns < 46
    assert run(source, "-o", "skin.npz", "--skin", "--of", "person") == 0
    with np.load("skin.npz") as kept:
        assert kept["pressure"].max() > 500.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-o", "map.png", "--of", "bde"), "did you mean bed?"),
        (("-o", "map.png", "--side", "up"), "--side: found 'up', expected one of top"),
        (
            (
                "-o",
                "map.txt",
            ),
            "expected a name in .png",
        ),
        (("-o", "skin.png", "--skin", "--of", "nobody"), "With --skin it is a person: person"),
        (("-o", "skin.png", "--skin", "--cell", "2"), "--side and --cell are of a thing's map"),
        (
            ("-o", "map.png", "--cell", "0"),
            "--cell: expected a number from 0.1 to 100 [cm], found 0",
        ),
        (("-o", "map.png", "--cell", "nan"), "--cell: expected a number from 0.1 to 100 [cm]"),
        (("-o", "map.png", "--cell", "101"), "from 0.1 to 100 [cm], found 101"),
        (("-o", "map.png", "--frame", "99"), "the map has 16 frames"),
    ],
)
def test_mistakes_are_one_line_and_write_nothing(source, tmp_path, capsys, arguments, message):
    assert run(source, *arguments) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_hard_result_says_what_is_missing(tmp_path, capsys):
    dataclasses.replace(soft_result(), soft_contacts=None).save(tmp_path / "hard.npz")
    assert run("hard.npz", "-o", "map.png") == 2
    assert "without anything soft" in capsys.readouterr().err


def test_a_motion_file_is_no_result(tmp_path, capsys):
    soft_result().motion.save(tmp_path / "walk.npz")
    assert run("walk.npz", "-o", "map.png") == 2
    assert "found no result" in capsys.readouterr().err


def test_cells_that_are_too_small_are_said_in_cm(source, monkeypatch, capsys):
    monkeypatch.setattr("halfphysics.results.pressure_maps.MOST_NUMBERS", 1000)
    assert run(source, "-o", "map.png", "--cell", "0.5") == 2
    assert "--cell: found 0.5 cm, for which 'bed' has " in capsys.readouterr().err
