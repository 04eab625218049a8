"""halfphysics serve."""

from __future__ import annotations

import dataclasses
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.cli import main
from halfphysics.cli import serve as cli_serve
from halfphysics.live.session import Session


def test_it_serves_for_a_time_and_says_how_it_went(tmp_path, capsys):
    path = tmp_path / "out.npz"
    assert main(["serve", "shake_hands", "--port", "0", "--for", "1", "-o", str(path)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"a live session of person0, person1 at ws://127\.0\.0\.1:\d+", said[0])
    assert re.match(r"\d+ frames; 0 clients; 0 poses dropped", said[1])
    assert said[2] == f"written: {path}"
    result = hp.Result.load(path)
    assert 5 < len(result) < 140  # a second at 90 Hz; a busy machine makes fewer steps
    assert main(["convert", str(path), str(tmp_path / "out.glb")]) == 0


def test_what_a_protocol_does_not_understand_is_said(capsys):
    """As where a program sends by another protocol than is listened for."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.bind(("127.0.0.1", 0))
        port = sender.getsockname()[1]
    over = threading.Event()

    def send():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not over.wait(0.02):
                out.sendto(b"no such thing", ("127.0.0.1", port))

    thread = threading.Thread(target=send)
    thread.start()
    try:
        assert main(["serve", "--port", "0", "--for", "0.5", "--listen", f"xsens:{port}"]) == 0
    finally:
        over.set()
        thread.join()
    said = capsys.readouterr().out.splitlines()[-1]
    assert f"; xsens:127.0.0.1:{port}: datagrams not understood as xsens: " in said
    assert said.endswith("no pose in what was heard")


@pytest.mark.parametrize(("rate", "said"), [(120, True), (90, False), (60, False)])
def test_who_is_sent_faster_than_the_physics_is_named(monkeypatch, rate, said):
    session = Session(body=[hp.Body.default()])
    monkeypatch.setattr(session.mailbox, "interval", lambda person: 1.0 / rate)
    assert cli_serve._fast(session) == []  # nobody sends
    monkeypatch.setattr(session.mailbox, "silence", lambda person: 0.0)
    expected = ["person is sent at 120 Hz: --fps 120 steps with every pose"] if said else []
    assert cli_serve._fast(session) == expected


def test_an_unfinished_recording_becomes_a_result(tmp_path, capsys, monkeypatch):
    from halfphysics.live.recording import Recorder

    monkeypatch.setattr(
        Recorder, "close", lambda self: (self._frames.put(None), self._thread.join())
    )
    path = tmp_path / "out.npz"
    assert main(["serve", "--port", "0", "--for", "0.5", "-o", str(path)]) == 0
    assert main(["convert", f"{path}.unfinished", str(tmp_path / "found.npz")]) == 0
    assert len(hp.Result.load(tmp_path / "found.npz")) > 2
    assert main(["convert", f"{path}.unfinished", str(tmp_path / "found.glb")]) == 0


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT for one process")
def test_ctrl_c_says_what_was_written(tmp_path):
    path = tmp_path / "out.npz"
    words = ["-m", "halfphysics", "serve", "--port", "0", "-o", str(path)]
    with subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("a live session")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        said = process.stdout.read().splitlines()
    assert said[-1] == f"written: {path}"
    assert process.returncode == 130
    assert len(hp.Result.load(path)) > 1


def test_a_session_without_frames_has_written_nothing(tmp_path, capsys, monkeypatch):
    from halfphysics.live.session import Session

    monkeypatch.setattr(Session, "step", lambda self: None)
    path = tmp_path / "out.npz"
    assert main(["serve", "--port", "0", "--for", "0.2", "-o", str(path)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[-1] == f"nothing to record: no frame was made, {path} is not written"
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_finished_is_said_to_be_unfinished(tmp_path, capsys, monkeypatch):
    def save(self, path):
        raise hp.errors.FileError(f"{path}: cannot write: No space left on device")

    monkeypatch.setattr(hp.Result, "save", save)
    path = tmp_path / "out.npz"
    assert main(["serve", "--port", "0", "--for", "0.5", "-o", str(path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"written: {path}.unfinished"
    assert not path.exists()


@pytest.fixture
def asked(monkeypatch):
    """What the command asks `serve` for; nothing is served."""
    from halfphysics.live import serve as module

    found = {}

    def serve(scene, **options):
        found.update(scene=scene, **options)
        raise hp.errors.InputError("enough")

    monkeypatch.setattr(module, "serve", serve)
    return found


@pytest.mark.parametrize("name", ["meet", "shake_hands"])
def test_people_of_a_scenario_have_their_own_bodies(name, asked):
    story = scenarios.load(name)
    assert main(["serve", name]) == 2
    assert [body.stature for body in asked["body"]] == [body.stature for body in story.bodies]
    for body, pose in zip(asked["body"], asked["start"], strict=True):
        assert body.vertices(pose)[..., 2].min() > -0.01  # [m]: nobody starts under the floor


def test_more_people_than_a_scenario_has_get_the_body_of_the_options(asked):
    own = [body.stature for body in scenarios.load("meet").bodies]
    assert main(["serve", "meet", "--people", "3"]) == 2
    assert [body.stature for body in asked["body"]] == [*own, hp.Body.default().stature]
    assert main(["serve", "meet", "--people", "1"]) == 2
    assert [body.stature for body in asked["body"]] == own[:1]
    assert main(["serve", "meet", "--people", "3", "--stature", "1.5"]) == 2
    assert [body.stature for body in asked["body"]] == pytest.approx([1.5] * 3)
    assert main(["serve", "meet", "--mass", "60"]) == 2
    assert [body.mass for body in asked["body"]] == pytest.approx([60.0] * 2)
    assert [body.stature for body in asked["body"]] == own


def test_settings_that_are_not_given_are_the_scenarios(asked):
    own = scenarios.load("fly_with_ball").settings
    assert own != hp.Settings()
    assert main(["serve", "fly_with_ball"]) == 2
    assert asked["settings"] == own
    assert main(["serve", "fly_with_ball", "--stiffness", "0.5"]) == 2
    assert asked["settings"] == dataclasses.replace(own, stiffness=0.5)
    assert main(["serve", "kick_ball", "--stiffness", "0.5"]) == 2
    assert asked["settings"] == hp.Settings(stiffness=0.5)


def test_the_scene_is_not_written_over(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "room.json"
    hp.Scene().save(path)
    before = path.read_bytes()
    for words in (["room.json"], ["--scene", "room.json"]):
        assert main(["serve", *words, "--port", "0", "--for", "0.1", "--out", "room.json"]) == 2
        assert "room.json: this is the input" in capsys.readouterr().err
        assert path.read_bytes() == before


def test_options_make_the_scene_and_the_people(asked):
    words = ["--object", "b=sphere:0.1,mass=1", "--people", "3", "--stature", "1.6", "--fps", "60"]
    assert (
        main(["serve", *words, "--listen", "vmc:1", "--listen", "vmc:2", "--origin", "null"]) == 2
    )
    assert list(asked["scene"].objects) == ["b"]
    assert [body.stature for body in asked["body"]] == pytest.approx([1.6] * 3)
    assert (asked["fps"], asked["listen"], asked["origins"]) == (
        60.0,
        ("vmc:1", "vmc:2"),
        ("null",),
    )
    assert asked["start"] is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere"], "no scene file and no scenario"),
        (["shake_hand"], "shake_hands"),
        (["nowhere.yaml"], "nowhere.yaml"),
        (["a.yaml", "--scene", "b.yaml"], "two scenes"),
        (["--people", "0"], "--people"),
        (["--for", "-1"], "--for"),
        (["--port", "99999"], "port"),
        (["--fps", "1"], "--fps"),
        (["--token", "abc"], "--token"),
        (["--listen", "telepathy"], "telepathy"),
        (["--body", "no.npz", "--stature", "1.6"], "--stature"),
        (["--out", "/no/such/folder/out.npz"], "folder"),
    ],
)
def test_mistakes(words, said, capsys):
    assert main(["serve", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
