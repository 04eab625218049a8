"""The command line: its results, and its messages for mistakes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.cli import COMMANDS
from halfphysics.formats.loading import GROUND
from support.as_it_is import as_it_is
from support.command_line import run
from support.motion_files import FRAMES, NAN, write_motion

#: The paper's drive, and nothing that it has not (`halfphysics.settings.AS_IT_IS`).
PAPER = (
    "--drive-time", "None", "--no-weight", "--blocked", "continue", "--root", "stay",
    "--no-joint-limits", "--strength", "None",
)  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working folder with walk.npz in it."""
    monkeypatch.chdir(tmp_path)
    write_motion("walk.npz")
    return tmp_path


# -- results -------------------------------------------------------------------------------


def test_simulate_evaluate_convert(folder, capsys):
    ball = "ball=sphere:0.11,mass=0.43,position=2:0:0.11"
    code = run(
        "simulate", "walk.npz", "--object", ball, "--static", "wall=box:0.1:2:2,position=0:2:1",
        "--stiffness", "3", *PAPER, "--out", "r.npz",
    )  # fmt: skip
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    assert "12 frames at 30 fps" in out
    assert "did not move (less than 1 mm, 1°): ball" in out
    assert "result: r.npz" in out
    result = hp.Result.load("r.npz")
    assert result.names == ("wall", GROUND, "ball", "person")
    assert result.settings == as_it_is(stiffness=3.0, drive_time=None)
    # The same call in Python gives the same numbers.
    scene = hp.Scene()
    scene.add_static("wall", hp.Box((0.1, 2, 2)), position=(0, 2, 1))
    scene.add_object("ball", hp.Sphere(0.11), mass=0.43, position=(2, 0, 0.11))
    scene.add_static(GROUND, hp.Plane())
    same = hp.simulate(hp.Motion.load("walk.npz"), scene, settings=result.settings)
    np.testing.assert_array_equal(result.motion.rotations, same.motion.rotations)
    np.testing.assert_array_equal(result.motion.translation, same.motion.translation)

    assert run("evaluate", "r.npz", "--json", "r.json") == 0
    out, err = capsys.readouterr()
    assert err == ""
    measured = json.loads((folder / "r.json").read_text())["people"][0]
    assert measured["success"] is True
    assert len(measured["simulated"]["penetration"]["share"]) == FRAMES
    assert measured["mpjpe_mm"] == pytest.approx(0.0, abs=1e-6)
    said, table = out.split("\n\n")
    assert said == result.summary()
    assert "followed exactly" in said
    rows = dict(re.split(r"\s{2,}", line, maxsplit=1) for line in table.splitlines()[2:])
    assert rows["skin vertices inside [%]"].split() == ["0.000", "0.000"]

    assert run("convert", "r.npz", "c.npz", "--to-fps", "60", "--format", "amass-smplh") == 0
    motion = hp.Motion.load("c.npz")
    assert (len(motion), motion.fps) == (2 * FRAMES - 1, 60.0)
    with np.load("c.npz") as file:
        assert file["poses"].shape[1] == 156
        assert not [key for key in file if "/" in key]


def test_a_recorded_carry(folder, carried_file, capsys):
    """What hands hold is said once each, and is off with one option."""
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # as in a separate program, not in this test run
        assert run("simulate", str(carried_file), "--out", "r.npz") == 0
        out, err = capsys.readouterr()
        assert err.count("halfphysics: warning: ") == 1
        lines = err.splitlines()
        assert lines[0].startswith(f"halfphysics: warning: {carried_file}, clip 'sub1_suitcase")
        (said,) = [line for line in lines if "adapted to what" in line]
        assert said.startswith("  adapted to what is held: suitcase")
        assert "(--no-ground: none)" in err
        assert "holds suitcase with left and right hand" in out
        assert run("evaluate", "r.npz", "--json", "r.json") == 0
        measured = json.loads((folder / "r.json").read_text())["people"][0]
        assert [hand["part"] for hand in measured["holds"]] == ["left_wrist", "right_wrist"]
        result = hp.Result.load("r.npz")
        error = hp.metrics.mpjpe(result.motion, result.recorded, result.people[0].body)
        assert measured["mpjpe_mm"] == error > 1.0
        capsys.readouterr()
        assert run("simulate", str(carried_file), "--no-grip") == 0
        assert "pressing with" not in capsys.readouterr().err
        assert (
            run("simulate", str(carried_file), "--no-adapt", "--no-ground", "--out", "b.npz") == 0
        )
    out, err = capsys.readouterr()
    assert "adapted to what" not in err
    assert "'ground'" not in err
    assert "holds suitcase" not in out
    bare = hp.Result.load("b.npz")
    assert bare.holds == ()
    assert bare.names == ("suitcase", "person")
    np.testing.assert_array_equal(bare.reference.rotations, result.recorded.rotations)


def test_evaluate_compares_each_person_with_their_own_reference(folder, capsys):
    """The reference is 10 cm beside both of them."""
    motion = hp.Motion.load("walk.npz")
    for name, x in (("pair.npz", 0.0), ("beside.npz", 0.1)):
        both = [
            motion.with_frames(motion.translation + np.array([x, y, 0.0]), motion.rotations)
            for y in (0.0, 3.0)
        ]
        hp.simulate(both, hp.Scene()).save(name)
    assert run("evaluate", "pair.npz", "--reference", "beside.npz") == 0
    out = capsys.readouterr().out
    assert len(re.findall(r"off the path at the end \[mm\]\s+100\.0", out)) == 2
    assert run("evaluate", "pair.npz", "--reference", "walk.npz") == 2
    assert "walk.npz holds one person, and the result 2" in capsys.readouterr().err


def test_evaluate_a_motion(folder, capsys):
    moved = np.zeros((FRAMES, 3))
    moved[:, 2] = 0.94
    moved[:, 0] = 0.01 * np.arange(FRAMES) + 0.004
    write_motion("other.npz", trans=moved)
    assert run("evaluate", "walk.npz", "--reference", "other.npz") == 0
    out = capsys.readouterr().out
    assert re.search(r"MPJPE \[mm\]\s+0\.000000", out)
    assert re.search(r"MPJPE-g \[mm\]\s+4\.000000", out)
    # All of the person is within a box of 4 m.
    assert (
        run("evaluate", "walk.npz", "--static", "box=box:4:4:4,position=0:0:1", "--no-ground") == 0
    )
    assert re.search(r"skin vertices inside \[%\]\s+100\.000", capsys.readouterr().out)


def test_a_body_model_that_is_gone_is_given_anew(folder, capsys):
    """The way out of the message is a way out."""
    from halfphysics.body import body as module

    (folder / "SMPLX_NEUTRAL.npz").write_bytes(module._ASSET.read_bytes())
    contact = ("--contact", "parts")
    assert run("simulate", "walk.npz", "--body", "SMPLX_NEUTRAL.npz", *contact, "-o", "r.npz") == 0
    (folder / "SMPLX_NEUTRAL.npz").rename("moved.npz")
    capsys.readouterr()
    assert run("evaluate", "r.npz") == 2
    err = capsys.readouterr().err
    assert err.endswith("is not there. Put it back, or give evaluate one with --body\n")
    assert run("evaluate", "r.npz", "--body", "moved.npz") == 0


def test_ground(folder, capsys):
    run("simulate", "walk.npz", "-o", "a.npz")
    run("simulate", "walk.npz", "-o", "b.npz", "--no-ground")
    run("simulate", "walk.npz", "-o", "c.npz", "--static", "deep=plane,position=0:0:-5")
    names = [hp.Result.load(f"{k}.npz").names[:-1] for k in "abc"]
    assert names == [(GROUND,), (), ("deep",)]


def test_grounded_and_frames(folder):
    assert run("simulate", "walk.npz", "--grounded", "--frames", "2:8", "-o", "r.npz") == 0
    result = hp.Result.load("r.npz")
    assert len(result) == 6
    lowest = result.people[0].body.vertices(result.reference)[..., 2].min()
    assert abs(lowest) < 1e-12  # of heights of about 1 m


def test_two_people(folder):
    shifted = np.zeros((FRAMES, 3))
    shifted[:, 1:] = (3.0, 0.94)
    write_motion("other.npz", trans=shifted)
    assert run("simulate", "walk.npz", "other.npz", "--out", "r.npz") == 0
    assert hp.Result.load("r.npz").names == (GROUND, "person0", "person1")


def test_scene_file(folder):
    (folder / "room.yaml").write_text("statics:\n  floor: {shape: plane}\n")
    assert run("simulate", "walk.npz", "--scene", "room.yaml", "--out", "r.npz") == 0
    assert hp.Result.load("r.npz").names == ("floor", "person")


def test_without_out_nothing_is_written(folder, capsys):
    assert run("simulate", "walk.npz") == 0
    assert "nothing written" in capsys.readouterr().out
    assert [p.name for p in folder.iterdir()] == ["walk.npz"]


@pytest.mark.slow
def test_demo(tmp_path, capsys):
    assert run("demo", "--out", tmp_path / "new" / "demo") == 0
    out, err = capsys.readouterr()
    assert err == ""
    files = {p.name: p.stat().st_size for p in (tmp_path / "new" / "demo").iterdir()}
    assert sorted(files) == ["demo.html", "result.npz", "strip.png"]
    assert (tmp_path / "new/demo/strip.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "new/demo/demo.html").read_text(encoding="utf-8")
    assert "<html" in page.lower()
    result = hp.Result.load(tmp_path / "new/demo/result.npz")
    # The table agrees with the files.
    assert out.count(result.summary()) == 1
    assert "motion followed exactly there" in out
    asked, simulated = map(float, re.search(r"deepest of all \[mm\]\s+(\S+)\s+(\S+)", out).groups())
    assert asked > 30.0
    assert simulated < 2.0  # the rigid parts are clear; the skin may penetrate a little
    assert re.search(r"\d+ frames/s", out)
    assert not re.search(r"\s-0\.0+\s", out)
    for name in files:
        assert str(tmp_path / "new" / "demo" / name) in out


# -- mistakes ------------------------------------------------------------------------------

SCENE = "statics:\n  wall:\n    shape: box\n    size: [1, 1, 1]\n    postion: [0, 0, 0]\n"

MISTAKES = {
    "missing file": (["nofile.npz"], r"nofile\.npz: no such file"),
    "wrong keys": (
        ["keys.npz"],
        r"keys\.npz: no known motion format.*something.*halfphysics formats",
    ),
    "a field missing": (["notrans.npz"], r"notrans\.npz: field 'trans' is missing.*expected trans"),
    "NaN": (["nan.npz"], r"nan\.npz: field 'poses': 1 values are NaN.*frame 3.*expected finite"),
    "one frame": (["one.npz"], r"one\.npz.*found 1 frame.*expected at least 2.*Repeat"),
    "truncated": (["cut.npz"], r"cut\.npz: damaged or truncated"),
    "text": (["text.npz"], r"text\.npz: no known motion format"),
    "unknown shape": (
        ["walk.npz", "--object", "ball=spere:0.1,mass=1"],
        r"unknown shape 'spere:0.1' \(did you mean sphere\?\), expected .*Example",
    ),
    "negative mass": (
        ["walk.npz", "--object", "ball=sphere:0.1,mass=-1"],
        r"object 'ball': mass: expected a number above 0 \[kg\], found -1",
    ),
    "mesh without triangles": (
        ["walk.npz", "--static", "rock=points.obj"],
        r"points\.obj: found no triangles.*expected a triangle mesh",
    ),
    "mesh missing": (["walk.npz", "--static", "rock=no.obj"], r"no\.obj: there is no such file"),
    "misspelt key": (
        ["walk.npz", "--scene", "bad.yaml"],
        r"bad\.yaml, line 5, statics\.wall\.postion: unknown key.*did you mean position.*Allowed",
    ),
    "option misspelt": (
        ["walk.npz", "--stifness", "3"],
        r"unknown option --stifness; did you mean --stiffness\?",
    ),
    "option impossible": (
        ["walk.npz", "--stiffness", "-3"],
        r"--stiffness is -3\.0; expected .*>= 0",
    ),
    "metres apart": (
        ["walk.npz", "--clearance", "5"],
        r"clearance is 5\.0; expected .* <= 0\.05 \[m\]: a body farther",
    ),
    "option no number": (["walk.npz", "--stiffness", "x"], r"--stiffness.*'x'"),
    "choice unknown": (["walk.npz", "--root", "x"], r"--root: found 'x', expected stay or recover"),
    "frames": (["walk.npz", "--frames", "a:b"], r"--frames: found 'a:b', expected START:STOP"),
    "no motion": ([], r"no motion file"),
    "body missing": (["walk.npz", "--body", "no.npz"], r"no\.npz: no such file"),
    "stature of a model": (
        ["walk.npz", "--body", "walk.npz", "--stature", "1.7"],
        r"--stature is for the default body",
    ),
    "the floor's name": (
        ["walk.npz", "--static", "ground=box:1:1:1"],
        r"called 'ground' that is no plane.*--no-ground",
    ),
    "output is input": (["walk.npz", "--out", "walk.npz"], r"walk\.npz: this is the input"),
    "output folder": (["walk.npz", "--out", "no/r.npz"], r"the folder no does not exist"),
    "output is a folder": (["walk.npz", "--out", "."], r"this is a folder"),
}


@pytest.fixture(scope="module")
def mistaken(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mistaken")
    write_motion(folder / "walk.npz")
    np.savez(folder / "keys.npz", something=np.zeros(3))
    write_motion(folder / "notrans.npz", trans=None)
    write_motion(folder / "nan.npz", poses=NAN)
    write_motion(folder / "one.npz", frames=1)
    (folder / "cut.npz").write_bytes((folder / "walk.npz").read_bytes()[:700])
    (folder / "text.npz").write_text("hello")
    (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    (folder / "bad.yaml").write_text(SCENE)
    return folder


@pytest.mark.parametrize("what", MISTAKES)
def test_mistakes_of_simulate(what, mistaken, monkeypatch, capsys):
    """Exit code 2, one message on stderr that suggests a fix, no file written."""
    monkeypatch.chdir(mistaken)
    before = sorted(mistaken.iterdir())
    arguments, message = MISTAKES[what]
    out = [] if "--out" in arguments else ["--out", "r.npz"]
    assert run("simulate", *arguments, *out) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("halfphysics: error: ")
    assert captured.err.count("\n") == 1
    assert re.search(message, captured.err), captured.err
    assert sorted(mistaken.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["simualte", "x"], "unknown command 'simualte'; did you mean simulate"),
        (["evaluate"], "RESULT_OR_MOTION"),
        (["evaluate", "walk.npz"], r"walk\.npz: a motion alone.*--scene.*--reference"),
        (["evaluate", "walk.npz", "--reference", "no.npz"], r"no\.npz: no such file"),
        (["convert", "walk.npz"], "OUT"),
        (["convert", "walk.npz", "x.fbx"], r"found suffix '\.fbx', expected one of .*\.npz"),
        (["convert", "walk.npz", "x.npz", "--format", "amas"], "expected one of .*amass-smplx"),
        (["convert", "walk.npz", "x.npz", "--to-fps", "-1"], "--to-fps: found -1"),
        (
            ["convert", "walk.npz", "x.npz", "--to-fps", "1e9"],
            "found 1e.09, expected at most 10000",
        ),
        (["convert", "walk.npz", "walk.npz"], "this is the input"),
        (["demo", "--out", "walk.npz"], r"walk\.npz: cannot make this folder"),
    ],
)
def test_other_mistakes(arguments, message, mistaken, monkeypatch, capsys):
    monkeypatch.chdir(mistaken)
    before = sorted(mistaken.iterdir())
    assert run(*arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert re.search(f"^halfphysics: error: .*{message}", captured.err), captured.err
    assert sorted(mistaken.iterdir()) == before


def test_warnings_are_lines_without_python_in_them(folder, capsys):
    write_motion("unsaid.npz", gender=None)
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # as in a separate program, not in this test run
        assert run("simulate", "unsaid.npz") == 0
    err = capsys.readouterr().err
    assert err == (
        "halfphysics: warning: unsaid.npz: no field 'gender': taken as neutral. "
        "Say it with --gender\n"
    )


# -- help and processes --------------------------------------------------------------------


def test_overview(capsys):
    assert run("--help") == 0
    out = capsys.readouterr().out
    for name, what in COMMANDS.items():
        assert re.search(rf"{name} +{re.escape(what)}", out)
    assert run() == 2  # nothing to do


@pytest.mark.parametrize("name", COMMANDS)
def test_help_has_an_example_that_parses(name, capsys):
    import importlib
    import shlex

    from halfphysics.cli.parsing import Exit, parse

    assert run(name, "--help") == 0
    out = capsys.readouterr().out
    module = importlib.import_module(f"halfphysics.cli.{name}")
    examples = [line for line in module.EXAMPLES.splitlines() if line]
    assert examples
    for line in examples:
        assert f"  {line}\n" in out
        program, command, *rest = shlex.split(line)
        assert (program, command) == ("halfphysics", name)
        if hasattr(module, "read"):
            assert isinstance(module.read("halfphysics", rest), Exit) == (rest == ["--list"])
        else:
            assert not isinstance(parse(module.Command, "halfphysics", "", rest), Exit)


def test_every_setting_is_an_option(capsys):
    import dataclasses

    run("simulate", "--help")
    out = capsys.readouterr().out
    for field in dataclasses.fields(hp.Settings):
        # A flag is followed by its opposite, every other option by its type.
        option = f"--{field.name.replace('_', '-')}"
        assert f"{option} " in out or f"{option}, --no-" in out


def program(*arguments, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "halfphysics", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def test_as_a_program(folder):
    process = program("--version")
    assert process.communicate(timeout=60) == (f"halfphysics {hp.__version__}\n", "")
    assert process.returncode == 0
    process = program("simulate", "nofile.npz", "--out", "r.npz")
    out, err = process.communicate(timeout=60)
    assert process.returncode == 2
    assert out == ""
    assert err.startswith("halfphysics: error: nofile.npz: no such file")
    assert "Traceback" not in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_progress_bars_are_for_terminals(folder):
    process = program("simulate", "walk.npz", "--out", "r.npz")
    _, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (0, "")


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_is_quiet_and_leaves_nothing(folder):
    write_motion("long.npz", frames=60_000)
    # A falling object takes a thousand steps a frame: a minute's work.
    ball = ("--object", "ball=sphere:0.1,mass=1,position=9:9:9", "--substeps", "1000")
    process = program("simulate", "long.npz", "--out", "r.npz", *ball)
    time.sleep(3.0)
    assert process.poll() is None, process.communicate()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "")
    assert sorted(p.name for p in folder.iterdir()) == ["long.npz", "walk.npz"]
