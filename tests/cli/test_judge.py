"""halfphysics judge: table, files, exit codes, mistakes."""

from __future__ import annotations

import csv
import json

import pytest

import halfphysics as hp
from halfphysics.cli import main
from support.made_clips import walk


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    walk().save("a.npz")
    walk(1).save("b.npz")
    (tmp_path / "broken.npz").write_bytes(b"no")
    return tmp_path


def test_table_and_files(folder, capsys):
    outputs = ["--csv", "m.csv", "--json", "m.json", "--page", "m.html", "--jobs", "1"]
    assert main(["judge", "a.npz", "b.npz", "broken.npz", "--truth", "a.npz", *outputs]) == 0
    said = capsys.readouterr().out
    assert "Phys-Err [mm]" in said
    assert "WA-MPJPE_100 [mm]" in said
    assert "not judged: broken.npz" in said
    assert "not measured, takes a scene: non-collision" in said
    rows = list(csv.DictReader((folder / "m.csv").read_text().splitlines()))
    expected = hp.metrics.judge(hp.Motion.load("b.npz"), truth=hp.Motion.load("a.npz"))
    assert [row["clip"] for row in rows] == ["a.npz", "b.npz", "broken.npz"]
    for key, value in expected.values.items():
        assert float(rows[1][key]) == pytest.approx(value, abs=1e-9), key
    clips = json.loads((folder / "m.json").read_text())["clips"]
    assert clips[1]["values"]["rte_percent"] == pytest.approx(expected["rte_percent"])
    assert "2 clips judged, 1 not" in (folder / "m.html").read_text()


def test_the_body_and_the_scene_of_the_options(folder, capsys):
    line = ["judge", "a.npz", "--stature", "1.5", "--static", "box=box:1:1:1", "--csv", "m.csv"]
    assert main(line) == 0
    (row,) = csv.DictReader((folder / "m.csv").read_text().splitlines())
    scene = hp.Scene()
    scene.add_static("box", hp.Box((1, 1, 1)))
    scene.add_static("ground", hp.Plane())
    body = hp.Body.default(stature=1.5)
    expected = hp.metrics.judge(hp.Motion.load("a.npz"), body, scene)
    for key in ("penetrate_mm", "depth_max_mm", "non_collision_percent"):
        assert float(row[key]) == pytest.approx(expected[key], abs=1e-9), key
    capsys.readouterr()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "FILE"),
        (["gone.npz"], "gone.npz: no such file or folder"),
        (["broken.npz"], "no clip could be judged"),
        (["a.npz", "--scene", "gone.yaml"], "gone.yaml"),
        (["a.npz", "--truth", "gone.npz"], "--truth gone.npz: no such file or folder"),
        (["a.npz", "--csv", "m.txt"], "--csv: found m.txt, expected a name that ends in .csv"),
        (["a.npz", "--page", "no/m.html"], "does not exist"),
        (["a.npz", "--jobs", "0"], "--jobs: found 0, expected at least 1"),
    ],
    ids=str,
)
def test_a_mistake_is_one_message(folder, capsys, arguments, words):
    before = sorted(folder.iterdir())
    assert main(["judge", *arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith("halfphysics: error: ")
    assert words in err
    assert sorted(folder.iterdir()) == before


def test_help(capsys):
    assert main(["judge", "--help"]) == 0
    said = capsys.readouterr().out
    for word in ("--truth", "--csv", "--json", "--page", "--jobs", "--scene", "examples:"):
        assert word in said
