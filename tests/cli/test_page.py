"""halfphysics page: what it takes, what it refuses."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from halfphysics.body import body as module
from halfphysics.cli import main
from support.people import along_x
from support.small_results import alone


@pytest.fixture
def result(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    alone().save("result.npz")
    return "result.npz"


def said(capsys):
    return capsys.readouterr().err


def test_a_recording_and_a_simulation_of_a_result(result, tmp_path, capsys):
    assert main(["page", result]) == 0
    assert "result.html" in capsys.readouterr().out
    recording = (tmp_path / "result.html").read_text(encoding="utf-8")
    assert main(["page", result, "--play", "--out", "play.html"]) == 0
    assert " MB; open it in a browser" in capsys.readouterr().out
    playing = (tmp_path / "play.html").read_text(encoding="utf-8")
    assert "\nstartPage(JSON" in recording
    assert "\nstartPlay(JSON" in playing


def test_what_is_neither(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["page", "kick_bal", "--play"]) == 2
    message = said(capsys)
    assert "no scenario and no file" in message
    assert "kick_ball" in message
    assert main(["page", "missing.npz"]) == 2
    assert "missing.npz" in said(capsys)


def test_names_of_pages(result, capsys):
    assert main(["page", result, "--out", "page.npz"]) == 2
    assert ".html" in said(capsys)


@pytest.mark.parametrize("option", [["--stature", "1.8"], ["--object", "a=sphere:1,mass=1"]])
def test_options_for_motions_are_for_motions(result, option, capsys):
    for what in (result, "kick_ball"):
        assert main(["page", what, "--play", *option]) == 2
        assert "leave them out" in said(capsys)


def test_another_model_needs_to_be_allowed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("SMPLX_NEUTRAL.npz").write_bytes(module._ASSET.read_bytes())
    clip = along_x(0.3, 6, 0.0, z=1.2)
    dataclasses.replace(clip, gender="female").save("walk.npz")
    words = ["page", "walk.npz", "--body", "SMPLX_NEUTRAL.npz", "--out", "p.html"]
    for how in ([], ["--play"]):
        assert main([*words, *how]) == 2
        assert "keep this body and its shape with --allow-mismatch" in said(capsys)
        assert main([*words, *how, "--allow-mismatch"]) == 0
