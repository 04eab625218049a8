"""Hearing a session: the newest frame, what is lost, coming back."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest

from halfphysics.errors import FileError, InputError
from halfphysics.live.client import LiveClient, connect
from halfphysics.live.schema import Add
from halfphysics.viewer.live_reader import LiveReader, Numbers
from support.live_sessions import FPS, session


def until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "too late"
        time.sleep(0.02)


def test_frames_that_are_missing_are_counted_and_clocks_compared():
    numbers = Numbers()
    numbers.connected()
    numbers.ping(0.010, 100.0)  # the server's clock is 100 s ahead
    numbers.ping(0.002, 100.5)
    for frame in (5, 6, 9):
        # Made by the server at its 110 s, heard 3 ms later.
        numbers.frame(SimpleNamespace(frame=frame, clock=110.0), 9.503)
    assert (numbers.heard, numbers.lost, numbers.trip) == (3, 2, 0.002)
    assert numbers.age == pytest.approx(0.003)
    assert numbers.rate == 0.0  # three frames in no time
    numbers.frame(SimpleNamespace(frame=10, clock=110.0), 9.603)
    assert numbers.rate == pytest.approx(30.0)
    numbers.connected()  # frames are counted anew by a new server
    numbers.ping(0.002, 0.0)
    numbers.frame(SimpleNamespace(frame=0, clock=1.0), 1.0)
    assert numbers.lost == 2


def test_a_session_is_heard_and_an_edit_is_noticed():
    with session() as server:
        reader = LiveReader(server.url)
        try:
            first = reader.frame.frame
            until(lambda: reader.frame.frame > first + 5)
            assert reader.numbers.rate > 0.0
            assert set(reader.frame.poses) == {"person"} == set(reader.frame.targets)
            scenes = reader.scenes
            with connect(server.url) as other:
                other.edit(Add("crate", "box:0.2:0.2:0.2", 1.0, (0.0, 2.0, 1.0)))
            until(lambda: reader.scenes > scenes)
            assert "crate" in {item.name for item in reader.hello.objects}
            until(lambda: "crate" in reader.frame.objects)
        finally:
            reader.stop()


def test_a_server_that_goes_and_comes_back():
    with session() as server:
        reader = LiveReader(server.url)
        port = server.server.port
    try:
        until(lambda: reader.trouble != "")
        from halfphysics.live.serve import serve
        from support.live_sessions import scene

        with serve(scene(), port=port, fps=FPS):
            until(lambda: reader.trouble == "")
            frame = reader.frame.frame
            until(lambda: reader.frame.frame > frame)
            assert reader.numbers.connections == 2
    finally:
        reader.stop()


def test_nobody_there():
    with pytest.raises(FileError, match="halfphysics serve"):
        LiveReader("ws://127.0.0.1:9")
    with pytest.raises((InputError, FileError)):
        LiveReader("ws://")


def test_a_session_that_makes_no_frames_is_refused_in_words(monkeypatch):
    def silent(self, timeout=None):
        raise TimeoutError

    monkeypatch.setattr(LiveClient, "receive", silent)
    with session() as server, pytest.raises(FileError, match="no frame came within 1 s"):
        LiveReader(server.url)
