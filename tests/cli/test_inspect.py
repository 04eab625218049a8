"""halfphysics inspect: what a file is, how it was read, three poses."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.render.contact_sheet import save_contact_sheet
from support.command_line import run


@pytest.fixture
def clip(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rotations = np.zeros((31, 55, 3))
    rotations[:, 0, 0] = np.pi / 2
    rotations[:, 18, 1] = np.linspace(0.0, 1.0, 31)
    way = np.outer(np.linspace(0.0, 1.0, 31), [2.0, 0.0, 0.0])
    motion = hp.Motion(way, rotations, 30.0, betas=np.zeros(10))
    motion.grounded(hp.Body.default()).save(tmp_path / "clip.npz")
    return "clip.npz"


def test_a_motion_is_described_and_drawn(clip, capsys):
    assert run("inspect", clip) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "clip.npz: amass-smplx, AMASS and what is written like it: SMPL-X" in out
    assert "poses (31, 165)" in out
    assert "31 frames at 30 fps (1.00 s), smplx, neutral, 10 betas; body of 1.73 m" in out
    assert "moves: body\n" in out
    assert "the pelvis goes 2.00 m" in out
    assert out.splitlines()[-1].split() == ["0.00", "s", "0.50", "s", "1.00", "s"]


def test_one_clip_is_one_and_what_is_still_but_for_rounding_is_still(clip, tmp_path, capsys):
    hp.export(hp.Motion.load(clip), tmp_path / "clip.glb")
    hp.Motion.load(clip).save(tmp_path / "clip.bvh", body=hp.Body.default())
    for name in ("clip.glb", "clip.bvh"):
        assert run("inspect", name) == 0
        out = capsys.readouterr().out
        assert "moves: body\n" in out
        assert "1 clips" not in out
        assert ("1 clip: take" in out) == (name == "clip.glb")


def test_what_was_assumed_is_said(clip, tmp_path, capsys):
    with np.load(clip) as known:
        fields = {key: known[key] for key in known.files if key != "gender"}
    np.savez(tmp_path / "other.npz", **fields)
    assert run("inspect", "other.npz") == 0
    out = capsys.readouterr().out
    assert "read with: " in out
    assert "gender" in out.split("read with: ")[1]


def test_a_picture_of_the_skin(clip, tmp_path):
    assert run("inspect", clip, "--picture", "look.png") == 0
    assert (tmp_path / "look.png").read_bytes()[:4] == b"\x89PNG"


def test_a_result_is_a_result(clip, capsys):
    assert run("simulate", clip, "--out", "result.npz") == 0
    assert run("inspect", "result.npz") == 0
    assert "a result of halfphysics simulate" in capsys.readouterr().out


def test_a_result_is_drawn_as_its_contact_sheet(clip, tmp_path, capsys):
    assert run("simulate", clip, "--out", "result.npz") == 0
    assert run("inspect", "result.npz", "--picture", "look.png") == 0
    assert "picture: look.png" in capsys.readouterr().out
    save_contact_sheet(hp.Result.load("result.npz"), "sheet.png")
    assert (tmp_path / "look.png").read_bytes() == (tmp_path / "sheet.png").read_bytes()


@pytest.mark.parametrize("option", [("--clip", "walk"), ("--stature", "1.6")])
def test_options_for_motions_are_refused_for_a_result(clip, capsys, option):
    assert run("simulate", clip, "--out", "result.npz") == 0
    assert run("inspect", "result.npz", *option) == 2
    assert "a result has its own bodies and frames" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["gone.npz"], "no such file"),
        (["text.txt"], "no known motion format"),
        (["clip.npz", "--picture", "look.gif"], "expected a name that ends in .png"),
        (["clip.npz", "--picture", "no/look.png"], "does not exist"),
    ],
)
def test_a_mistake_is_one_message(clip, tmp_path, capsys, arguments, words):
    (tmp_path / "text.txt").write_text("no motion")
    assert run("inspect", *arguments) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.startswith("halfphysics: error: ")
