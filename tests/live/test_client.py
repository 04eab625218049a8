"""The client in Python."""

from __future__ import annotations

import collections
import threading
import time

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.live import client, schema
from halfphysics.live.client import _frame
from halfphysics.live.safety import Gate
from halfphysics.live.server import Server
from halfphysics.live.session import Session


@pytest.fixture
def live(server):
    with hp.connect(f"ws://127.0.0.1:{server.port}") as made:
        yield made


def test_who_is_there(live):
    assert live.people == ("person0", "person1")
    assert live.fps == pytest.approx(90.0)
    assert live.hello.objects[0].name == "ball"


def test_poses_in_frames_out(live):
    pose = live.receive(20).poses["person0"]
    both = {
        "person0": pose,
        "person1": hp.Pose(np.add(pose.translation, (0, 1, 0)), pose.rotations),
    }
    for k in range(200):
        live.send(both, time=float(k), tracked={"person1": np.ones(55, dtype=bool)})
        frame = live.receive(20)
        if len(frame.stamps) == 2:
            break
    assert frame.stamps["person0"].sent == frame.stamps["person1"].sent
    assert frame.tracking["person0"] == "live"
    assert frame.objects["ball"][0].shape == (3,)
    assert frame.poses["person1"].rotations.shape == (55, 3)
    assert frame.targets == {}
    assert {contact.other for contact in frame.contacts} <= {"floor", "wall", "ball"}
    assert frame.clearance < 0.1


def test_one_pose_is_the_first_person_s(live):
    live.send(live.receive(20).poses["person0"], time=3.0)
    frames = (live.receive(20) for _ in range(200))
    stamps = next(frame.stamps for frame in frames if frame.stamps)
    assert {name: stamp.sent for name, stamp in stamps.items()} == {"person0": 3.0}


def test_edits_and_subscriptions(live):
    live.subscribe(["targets"], people=["person1"])
    frame = live.receive(20)
    assert (frame.poses, frame.objects, list(frame.targets)) == ({}, {}, ["person1"])
    live.subscribe()
    live.edit(schema.Mass("ball", 2.0))
    live.edit(schema.Remove("ball"))
    assert "ball" not in live.receive(20).objects
    with pytest.raises(InputError, match="ball"):
        live.edit(schema.Mass("ball", 2.0))
    assert live.receive(20).frame > 0


def test_mistakes_of_others_are_raised(live):
    live.send({"eve": live.receive(20).poses["person0"]})
    with pytest.raises(InputError, match="expected one of person0"):
        collections.deque(live, 0)


def test_an_edit_that_was_done_is_not_refused_for_another_message(live):
    """That a pose is for nobody is said by the next `receive`."""
    nobody = {"eve": live.receive(20).poses["person0"]}
    for call in (lambda: live.edit(schema.Mass("ball", 2.0)), live.subscribe, live.ping):
        live.send(nobody)
        call()
        with pytest.raises(InputError, match="expected one of person0"):
            live.receive(20)
        assert live.receive(20).frame > 0
    with pytest.raises(InputError, match="no message of version"):
        live.edit(schema.Add("crate", "box:1:1:1", 1.0, (1e9, 0.0, 0.0)))
    live.send(hp.Pose((0.0, 0.0, 1e9), np.zeros((55, 3))))
    live.edit(schema.Mass("ball", 2.0))
    with pytest.raises(InputError, match="no message of version"):
        live.receive(20)


def test_a_session_of_nobody_takes_no_pose():
    session = Session(body=[])
    server = Server(session, Gate("127.0.0.1"), 0)
    server.start()
    try:
        url = f"ws://127.0.0.1:{server.port}"
        with hp.connect(url) as live, pytest.raises(InputError, match="nobody in the session"):
            live.send(hp.Pose((0.0, 0.0, 1.0), np.zeros((55, 3))))
    finally:
        server.stop()


def test_other_axes_are_refused(live):
    pose = live.receive(20).poses["person0"]
    turned = hp.Pose(pose.translation, pose.rotations, [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    with pytest.raises(InputError, match="rebased"):
        live.send(turned)


def test_the_end_of_a_session(session):
    server = Server(session, Gate("127.0.0.1"), 0)
    server.start()
    session.start()
    with hp.connect(f"ws://127.0.0.1:{server.port}") as live:
        live.receive(20)
        server.stop()
        assert len(list(live)) < 200  # ends by itself
        with pytest.raises(FileError, match="closed"):
            live.send(session.newest.poses["person0"])
        with pytest.raises(FileError, match="closed"):
            live.receive(20)


def test_a_client_that_has_not_read_is_closed_at_once(live, server):
    """Frames that wait do not hold the closing handshake up until its time is over."""
    for _ in range(3):
        live.receive(20)
    time.sleep(1.0)
    begun = time.monotonic()
    live.close()
    assert time.monotonic() - begun < 5.0  # nothing; before, the ten seconds of a time limit


def test_a_timeout(session):
    server = Server(session, Gate("127.0.0.1"), 0)
    server.start()
    try:
        with hp.connect(f"ws://127.0.0.1:{server.port}") as live, pytest.raises(TimeoutError):
            live.receive(0.05)
    finally:
        server.stop()


@pytest.mark.parametrize(
    ("url", "error", "said"),
    [
        ("127.0.0.1:1", InputError, "ws://"),
        ("http://127.0.0.1:1", InputError, "ws://"),
        (8765, InputError, "url: found 8765, expected such as ws://"),
        ("ws://127.0.0.1:1", FileError, "Start halfphysics serve"),
        ("ws://127.0.0.1:65536", InputError, "url: found ws://127.0.0.1:65536, where nothing can"),
        ("ws://host:port", InputError, "url: found ws://host:port, where nothing can be"),
        ("ws://[::1", InputError, "url: found .* expected such as ws://"),
        (f"ws://{'a' * 70}.example", InputError, "url: found .* expected such as ws://"),
    ],
)
def test_where_nobody_answers(url, error, said):
    with pytest.raises(error, match=said):
        hp.connect(url)


def test_a_token_is_needed(session):
    server = Server(session, Gate("127.0.0.1", "secret-12"), 0)
    server.start()
    try:
        url = f"ws://127.0.0.1:{server.port}"
        with pytest.raises(FileError, match="token"):
            hp.connect(url)
        with hp.connect(url, token="secret-12") as live:
            assert live.people
        with hp.connect(f"{url}/?token=secret-12") as live:
            assert live.people
    finally:
        server.stop()


def test_a_pose_of_another_number_of_joints_is_refused():
    """Its numbers are checked by the schema, their count by the client."""
    person = schema.PersonFrame("live", None, [0.0, 0.0, 1.0], [[0.0, 0.0, 0.0]] * 54)
    message = schema.FrameMessage(
        frame=1, time=0.0, clock=0.0, clearance=None, people={"person": person}
    )
    with pytest.raises(InputError, match=r"\(54, 3\) numbers, expected \(3,\) and \(55, 3\)"):
        _frame(message)


def test_a_server_that_never_greets_is_left(monkeypatch):
    from websockets.sync.server import serve

    monkeypatch.setattr(client, "_OPENS", 0.2)
    with serve(
        lambda socket: time.sleep(1.0), "127.0.0.1", 0, subprotocols=[schema.MSGPACK_PROTOCOL]
    ) as silent:
        threading.Thread(target=silent.serve_forever, daemon=True).start()
        port = silent.socket.getsockname()[1]
        with pytest.raises(FileError, match=r"says nothing for 0\.2 s; expected a live session"):
            hp.connect(f"ws://127.0.0.1:{port}")
