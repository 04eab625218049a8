"""`hp.serve`, and a process that is killed while it records."""

from __future__ import annotations

import pytest

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.live import protocols
from support.live.process import ServerProcess


def test_a_session_with_all_of_it(scene, tmp_path):
    path = tmp_path / "out.npz"
    with hp.serve(scene, body=[hp.Body.default()] * 2, port=0, record=path) as served:
        assert repr(served) == f"LiveServer(2 people, at {served.url})"
        with hp.connect(served.url) as live:
            pose = live.receive(20).poses["person1"]
            for _ in range(30):
                live.send({"person1": pose})
                live.receive(20)
        assert 0.0 < served.latency.percentiles(50.0)[0] < 10.0  # [s]
    assert not served.running
    assert repr(served) == "LiveServer(2 people, stopped)"
    served.stop()  # twice is fine
    result = hp.Result.load(path)
    assert len(result) == served.session.frames
    assert served.recorder.left_out == 0


def test_clients_get_a_frame_before_it_is_recorded(scene, tmp_path):
    """Nobody who waits for a frame waits for the disk."""
    with hp.serve(scene, port=0, record=tmp_path / "out.npz") as served:
        told = [listener.__self__ for listener in served.session._listeners]
        assert told == [served.server, served.latency, served.recorder]


def test_beyond_this_machine_there_is_a_token(scene):
    with hp.serve(scene, host="0.0.0.0", port=0) as served:
        assert "/?token=" in served.url
        assert served.url.startswith("ws://127.0.0.1:")
        with hp.connect(served.url) as live:
            assert live.people == ("person",)
        with pytest.raises(FileError, match="token"):
            hp.connect(served.url.partition("/?")[0])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"fps": 5.0}, "fps"),
        ({"fps": float("nan")}, "fps"),
        ({"port": -1}, "port"),
        ({"port": 2.5}, "port"),
        ({"token": "short"}, "token"),
        ({"host": "no.such.host.invalid"}, "no address"),
        ({"listen": ["vmc:0", "vmc:0"]}, "at most one for each"),
        ({"listen": ["telepathy"]}, "telepathy"),
        ({"listen": ["vmc"], "forward": ["vmc"]}, r"follow themselves.*vmc:127\.0\.0\.1:39540"),
        ({"listen": ["vmc,calibrate=5"], "forward": ["vmc:localhost:39539"]}, "follow themselves"),
        ({"listen": "vmc:39539"}, r"listen: found 'vmc:39539', expected a list.*\['vmc:39539'\]"),
        ({"forward": [3]}, r"forward: found \[3\], expected a list"),
        ({"origins": "http://a.b"}, r"origins: found .*expected a list.*\['http://a\.b'\]"),
        ({"origins": None}, "origins: found None, expected a list"),
        ({"host": None}, "host: found None, expected an address"),
        ({"token": 12345678}, "token: found int, expected text"),
        ({"record": 3}, "path: expected the path of a file"),
        ({"settings": "stiff"}, "settings: found 'stiff', expected"),
        ({"start": 3}, r"start: found 3, expected a list of one halfphysics\.Pose a person"),
        ({"start": ["T"]}, r"start: found 'T', expected a list of one halfphysics\.Pose"),
    ],
)
def test_mistakes(scene, options, said):
    with pytest.raises(InputError, match=said):
        hp.serve(scene, **{"port": 0, **options})


def test_a_recording_is_of_people(scene, tmp_path):
    """Nothing could read one of nobody; without one such a session is fine."""
    with pytest.raises(InputError, match="record: found a session without people"):
        hp.serve(scene, body=[], port=0, record=tmp_path / "out.npz")
    assert list(tmp_path.iterdir()) == []
    with hp.serve(scene, body=[], port=0) as served:
        assert served.session.people == ()


def test_a_way_out_that_fails_closes_those_before(scene, monkeypatch):
    made, sender = [], protocols.sender

    def opened(text, **options):
        made.append(sender(text, **options))
        return made[-1]

    monkeypatch.setattr(protocols, "sender", opened)
    with pytest.raises(InputError, match="host is not found"):
        hp.serve(
            scene, body=[hp.Body.default()] * 2, port=0, forward=["vmc:9", f"vmc:{'a' * 70}:9"]
        )
    (first,) = made
    assert first._socket.fileno() == -1


def test_lists_are_anything_that_gives_texts(scene):
    """Sets and iterators too; receivers and senders are as many as were given."""
    given = {"listen": iter(["vmc:0"]), "forward": {"vmc:9"}, "origins": {"http://a.b": 1}}
    with hp.serve(scene, port=0, **given) as served:
        assert len(served.receivers) == 1


def test_what_failed_to_start_leaves_nothing(scene, tmp_path):
    """The port is free again, and no thread of it runs."""
    with hp.serve(scene, port=0) as served:
        port = served.server.port
    with pytest.raises(InputError, match="telepathy"):
        hp.serve(scene, port=port, listen=["telepathy"])
    with hp.serve(scene, port=port) as served:
        assert served.server.port == port


def test_poses_come_in_by_another_protocol(scene):
    with hp.serve(scene, port=0, listen=["vmc:0"]) as served:
        assert served.running


def test_killed_it_has_recorded_all_but_the_last_second(tmp_path):
    server = ServerProcess("shake_hands", "--out", str(tmp_path / "out.npz"))
    with hp.connect(server.url) as live:
        while (last := live.receive(20)).time < 3.0:
            pass
        server.kill()
    result = hp.Result.load(tmp_path / "out.npz.unfinished")
    # Blocks are written twice a second; tests that run beside this one may delay one of them.
    assert len(result) / result.fps > last.time - 2.0
    assert not (tmp_path / "out.npz").exists()


def test_pages(scene):
    """Pages that are there are served; none is needed."""
    from halfphysics.live.pages import pages

    for path, (kind, content) in pages().items():
        assert path.startswith("/")
        assert kind.startswith("text/html")
        assert content
