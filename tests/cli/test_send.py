"""halfphysics send: what arrives, and its messages for mistakes."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.live import protocols
from support.command_line import run
from support.live_frames import BODY, PERSON, UPRIGHT, furthest


@pytest.fixture
def clip(tmp_path, monkeypatch):
    """walk.npz: ten frames at 50 a second, arms that swing; and the motion in it."""
    monkeypatch.chdir(tmp_path)
    rotations = np.zeros((10, 55, 3))
    rotations[:, 0] = UPRIGHT
    rotations[:, 16, 1] = np.linspace(0.0, 0.5, 10)
    translation = np.zeros((10, 3))
    translation[:, 2] = 0.94
    motion = hp.Motion(translation, rotations, 50.0)
    motion.save("walk.npz")
    return motion


@pytest.mark.parametrize("name", ["vmc", "mocopi", "xsens", "rokoko"])
def test_a_receiver_gets_the_clip(clip, capsys, name):
    poses = []
    receiver = protocols.receiver(f"{name}:0", person=PERSON, body=BODY)
    receiver.start(poses.append)
    assert run("send", "walk.npz", "--as", receiver.endpoint) == 0
    end = time.monotonic() + 30.0
    while not poses or furthest(poses[-1].pose, clip[9], [0, 16, 18]) > 0.1:
        assert time.monotonic() < end
        time.sleep(0.01)
    receiver.stop()
    assert "walk.npz to" in capsys.readouterr().out


def test_a_live_session_gets_the_clip(clip, capsys):
    with hp.serve(port=0, fps=60.0) as live:
        url = f"ws:127.0.0.1:{live.server.port}"
        told = set()
        live.session.listen(lambda frame: told.update(frame.tracking.values()))
        assert run("send", "walk.npz", "--as", url, "--speed", "0.5") == 0
        end = time.monotonic() + 30.0
        while "live" not in told:
            assert time.monotonic() < end
            time.sleep(0.01)
    # Ten frames of 1/50 s at half speed; longer where the machine is busy.
    assert float(re.search(r"frames in (\S+) s", capsys.readouterr().out)[1]) >= 0.36


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--as", "vcm"], "did you mean vmc"),
        (["--as", "vmc:10.0.0.7:39539"], "Add --remote to send there"),
        (["--as", "ws://example.org:8765"], "Add --remote to send there"),
        (["--as", "vmc:1:2:x"], "port from 0"),
        (["--as", "vmc", "--speed", "0"], "--speed: expected a number above 0, found 0"),
        (["--as", "vmc", "--to-fps", "-1"], "--to-fps: expected a number above 0, found -1"),
        (["--as", "vmc", "--to-fps", "nan"], "--to-fps: expected a number above 0, found nan"),
        (["--as", "vmc", "--for", "-1"], "--for: expected a number above 0 [s], found -1"),
        (
            ["--as", "vmc", "--to-fps", "9000", "--speed", "0.5"],
            "--to-fps 9000, divided by --speed 0.5: found 18000, expected at most 10000",
        ),
        (["--as", "ws:127.0.0.1:9"], "nothing answers there"),
        (["--as", "pico"], "not known"),
    ],
)
def test_mistakes(clip, capsys, arguments, message):
    assert run("send", "walk.npz", *arguments) == 2
    out, err = capsys.readouterr()
    assert message in " ".join(err.split())
    assert out == ""


def test_a_result_is_sent_with_its_own_body(clip, monkeypatch):
    own = hp.Body.default(stature=1.5)
    hp.simulate(clip, body=own, settings=hp.Settings(contact="parts")).save("r.npz")
    given = []

    def sender(text, *, person, body):
        given.append(body.stature)
        raise hp.errors.InputError("enough")

    monkeypatch.setattr(protocols, "sender", sender)
    for words in ([], ["--stature", "1.9"], ["--mass", "60"]):
        assert run("send", "r.npz", "--as", "vmc", *words) == 2
    assert given == pytest.approx([1.5, 1.9, 1.5])
