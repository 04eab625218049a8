"""Fifty mistakes on the command line: exit code 2, one message, no Python in it, nothing written.

A judgement of the project: each is what somebody typed who meant something else. The message says
the words of the second column, in this order.
"""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import halfphysics as hp
from support.command_line import run
from support.motion_files import NAN, write_motion
from support.python_names import python_names

BALL = "ball=sphere:0.11,mass=0.43"
PLAN = "inputs:\n  - files: walk.npz\noutputs: {folder: data}\n"
WALK = ["simulate", "walk.npz"]

MISTAKES = [
    # commands and options
    (["simulat", "walk.npz"], "unknown command 'simulat' did you mean simulate"),
    (["simulate"], "no motion file --help"),
    (["--versoin"], "unknown command '--versoin'. Expected"),
    ([*WALK, "--stifness", "2"], "unknown option --stifness did you mean --stiffness"),
    ([*WALK, "--out"], "--out needs a value"),
    ([*WALK, "--stiffness", "high"], "--stiffness found 'high' expected a number"),
    ([*WALK, "--stiffness", "arm=2"], "--stiffness no joint 'arm' left_knee"),
    ([*WALK, "--stiffness", "-1"], "--stiffness is -1 expected"),
    ([*WALK, "--drive-time", "0"], "--drive-time is 0 expected"),
    ([*WALK, "--drive-time", "none", "--strength", "arms=40"],
     "--strength is arms=40 expected none without --drive-time"),
    ([*WALK, "--substeps", "2.5"], "--substeps found '2.5' expected a whole number"),
    ([*WALK, "--root", "back"], "--root found 'back' expected stay or recover"),
    ([*WALK, "--mode", "torques"], "--mode found 'torques' expected velocity torque"),
    ([*WALK, "--mode", "kinematic", "--blocked", "wait", "--joint-damping", "3"],
     "--joint-damping is 3 with --mode kinematic"),
    ([*WALK, "--mode", "kinematic", "--self-contact"], "--self-contact is true"),
    ([*WALK, "-q", "-v"], "--quiet or --verbose"),
    ([*WALK, "--open"], "--open --page FILE"),
    (["play", "kick_bal"], "kick_bal did you mean kick_ball"),
    (["scenario", "walk"], "unknown scenario 'walk' walk_into_wall"),
    (["scenario", "kick_ball", "--speed", "99"], "--speed found 99 expected 0.5 to 15"),
    (["bench", "--case", "wal"], "unknown case 'wal' wall"),
    # motion files
    (["simulate", "wlak.npz"], "wlak.npz no such file"),
    (["simulate", "."], "folder of no known format halfphysics judge"),
    (["simulate", "room.yaml"], "room.yaml no known motion format halfphysics formats"),
    (["simulate", "cut.npz"], "cut.npz damaged or truncated"),
    (["simulate", "nan.npz"], "nan.npz NaN frame 3 --frames START:STOP"),
    (["simulate", "nofps.npz", "--fps", "0"], "--fps found 0 expected a positive number"),
    (["simulate", "jump.npz"], "m/s frames 5 and 6 metres --frames START:STOP"),
    (["simulate", "model.npz"], "body model expected a motion --body"),
    ([*WALK, "--frames", "500:600"], "--frames found 500:600 walk.npz has 12 frames"),
    ([*WALK, "--frames", "3-7"], "--frames found '3-7' expected START:STOP"),
    ([*WALK, "--clip", "second"], "--clip found 'second' one motion only"),
    ([*WALK, "--up", "w"], "--up found 'w' expected y, z"),
    ([*WALK, "--assets", "nowhere"], "--assets found 'nowhere' folder that exists"),
    ([*WALK, "--model", "smplxx"], "--model found 'smplxx' smplx"),
    (["simulate", "walk.npz", "fast.npz"], "12 frames at 60 fps 12 at 30 halfphysics convert"),
    # bodies
    ([*WALK, "--body", "SMPLX.npz"], "SMPLX.npz no such file leave out --body"),
    ([*WALK, "--body", "walk.npz", "--stature", "1.8"], "--stature default body"),
    ([*WALK, "--stature", "180"], "--stature 180 expected metres"),
    ([*WALK, "--mass", "-70"], "--mass found -70 expected 1 to 500"),
    # scenes
    ([*WALK, "--scene", "room.obj"], "room.obj suffix '.obj' --static NAME=FILE"),
    ([*WALK, "--scene", "bad.yaml"], "bad.yaml line 5 postion did you mean position"),
    ([*WALK, "--object", "ball=sphere:0.11"], "expected mass= density= found neither"),
    ([*WALK, "--object", "ball=sfere:0.11,mass=1"], "unknown shape 'sfere:0.11' sphere"),
    ([*WALK, "--object", f"{BALL},position=1:0"], "position found '1:0' NUMBER:NUMBER:NUMBER"),
    ([*WALK, "--object", f"{BALL},weight=2"], "unknown key 'weight' allowed mass"),
    ([*WALK, "--object", BALL, "--object", BALL], "an object of this name already"),
    ([*WALK, "--object", "slab=plane,mass=1"], "a plane has no volume planes are static"),
    ([*WALK, "--static", "wall=wall.objj"], "wall.objj no such file"),
    ([*WALK, "--static", "box=box:1:1:1,up=y"], "scale and up are for meshes give the box its"),
    ([*WALK, "--static", "ground=box:1:1:1"], "'ground' no plane --no-ground"),
    # results and outputs
    (["view", "model.npz"], "body model expected a motion"),
    (["evaluate", "walk.npz"], "walk.npz a motion alone --scene --reference"),
    (["evaluate", "walk.npz", "--json", "no/m.json"], "no does not exist"),
    (["render", "walk.npz"], "render found one file expected a result and the file to write"),
    (["render", "walk.npz", "film.avi"], "film.avi found suffix '.avi' .html .mp4"),
    (["convert", "walk.npz", "walk.fbx"], "found suffix '.fbx' .npz"),
    (["convert", "walk.npz", "x.npz", "--format", "amas"], "--format found 'amas' amass-smplx"),
    (["convert", "walk.npz", "x.npz", "--to-fps", "-5"], "--to-fps found -5"),
    ([*WALK, "--out", "walk.npz"], "walk.npz this is the input"),
    ([*WALK, "--out", "no/r.npz"], "the folder no does not exist Create it"),
    ([*WALK, "--page", "page.htm"], "--page found page.htm .html"),
    ([*WALK, "--film", "film.mov"], "--film found film.mov .mp4"),
    ([*WALK, "--out", "/dev/null"], "/dev/null pipe or a device"),
    (["fix", "walk.npz", "--smooth", "-1"], "--smooth -1"),
    (["judge", "nothing/"], "nothing no such file or folder"),
    (["inspect", "walk.npz", "--picture", "p.gif"], "--picture p.gif .png"),
    # plans
    (["sweep", "plan.yml.bak"], "plan.yml.bak"),
    (["sweep", "factor.yaml"], "factor.yaml line settings.stifness stiffness"),
    (["sweep", "impossible.yaml", "--dry-run"], "object.ball.mass no object called 'ball'"),
]  # fmt: skip


@pytest.fixture(scope="module")
def mistaken(tmp_path_factory):
    """A folder of files as people have them."""
    folder = tmp_path_factory.mktemp("fifty")
    write_motion(folder / "walk.npz")
    write_motion(folder / "fast.npz", mocap_frame_rate=np.array(60.0))
    write_motion(folder / "nan.npz", poses=NAN)
    write_motion(folder / "nofps.npz", mocap_frame_rate=None)
    jump = np.zeros((12, 3))
    jump[:, 2], jump[6:, 0] = 0.94, 30.0
    write_motion(folder / "jump.npz", trans=jump)
    (folder / "cut.npz").write_bytes((folder / "walk.npz").read_bytes()[:700])
    np.savez(folder / "model.npz", v_template=np.zeros((9, 3)), J_regressor=np.zeros((2, 9)))
    (folder / "room.yaml").write_text("statics:\n  floor: {shape: plane}\n")
    (folder / "bad.yaml").write_text(
        "statics:\n  wall:\n    shape: box\n    size: [1, 1, 1]\n    postion: [0, 0, 0]\n"
    )
    (folder / "room.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "factor.yaml").write_text(f"{PLAN}factors:\n  settings.stifness: [1, 2]\n")
    (folder / "impossible.yaml").write_text(f"{PLAN}factors:\n  object.ball.mass: [1, 2]\n")
    return folder


def test_there_are_fifty():
    assert len({tuple(arguments) for arguments, _ in MISTAKES}) == len(MISTAKES) >= 50


@pytest.mark.parametrize(
    ("arguments", "words"), MISTAKES, ids=[" ".join(arguments) for arguments, _ in MISTAKES]
)
def test_a_mistake(arguments, words, mistaken, monkeypatch, capsys):
    monkeypatch.chdir(mistaken)
    before = sorted(mistaken.iterdir())
    with warnings.catch_warnings():
        warnings.simplefilter("default")  # as in a separate program, not in this test run
        assert run(*arguments) == 2
    out, err = capsys.readouterr()
    *told, message = err.splitlines()
    assert out == ""
    assert all(line.startswith(("halfphysics: warning: ", "  ")) for line in told)
    assert message.startswith("halfphysics: error: ")
    assert message.count("halfphysics: error: ") == 1
    assert re.search(".*?".join(map(re.escape, words.split(" "))), message), message
    assert python_names(message.removeprefix("halfphysics: error: ")) == []
    assert not re.search(r"Traceback|0x[0-9a-f]{6}|\w+Path\(|<[a-z]+ ", err)
    assert sorted(mistaken.iterdir()) == before
    assert hp.__version__ not in err
