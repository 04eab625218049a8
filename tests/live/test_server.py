"""The WebSocket server: clients, watchers, pages, and what it refuses."""

from __future__ import annotations

import contextlib
import http.client
import json
import socket
import threading
import time

import msgspec
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import halfphysics as hp
from halfphysics.errors import FileError, InputError
from halfphysics.live import safety, schema
from halfphysics.live import server as module
from halfphysics.live.safety import Gate
from halfphysics.live.server import Server
from support.live.faults import provoke


def opened(server, **options):
    return connect(
        f"ws://127.0.0.1:{server.port}", compression=None, max_size=None, proxy=None, **options
    )


def until(live, kind):
    """The next message of a type."""
    deadline = time.monotonic() + 60.0
    while True:
        assert time.monotonic() < deadline, f"no {kind}"
        data = live.recv(20)
        message = json.loads(data) if isinstance(data, str) else msgspec.msgpack.decode(data)
        if message["type"] == kind:
            return message


def pose_of(frame, person="person0", **changes):
    its = frame["people"][person]
    pose = {"translation": its["translation"], "rotations": its["rotations"]}
    return json.dumps({"type": "pose", "people": {person: pose}, **changes})


def test_the_first_message_says_all_there_is(server):
    with opened(server) as live:
        hello = json.loads(live.recv(20))
    assert hello["type"] == "hello"
    assert hello["version"] == schema.VERSION
    assert hello["fps"] == pytest.approx(90.0)
    assert hello["joints"] == list(hp.JOINT_NAMES)
    assert [p["name"] for p in hello["people"]] == ["person0", "person1"]
    assert [s["name"] for s in hello["statics"]] == ["floor", "wall"]
    assert hello["objects"][0]["mass"] == 1.0


def test_what_its_owner_adds_to_the_scene_later_is_not_in_the_session(server, scene):
    """Clients see what is simulated, at the start and after an edit."""
    scene.add_static("late", hp.Box((1, 1, 1)), position=(0, 9, 0))
    with opened(server) as live:
        hello = json.loads(live.recv(20))
        heavier = {"action": "mass", "name": "ball", "value": 2}
        live.send(json.dumps({"type": "edit", "edit": heavier}))
        changed = until(live, "scene")
    for message in (hello, changed):
        assert [s["name"] for s in message["statics"]] == ["floor", "wall"]


def test_a_pose_comes_back_with_its_time(server):
    with opened(server) as live:
        live.send(pose_of(until(live, "frame"), time=12.5))
        for _ in range(200):
            frame = until(live, "frame")
            if frame["people"]["person0"]["stamp"]:
                break
        stamp = frame["people"]["person0"]["stamp"]
        assert stamp["sent"] == 12.5
        assert stamp["received"] < stamp["stepped"] < frame["clock"]
        assert frame["people"]["person1"]["stamp"] is None


@pytest.mark.parametrize(
    ("offered", "kind"),
    [
        (None, str),
        ([schema.JSON_PROTOCOL], str),
        ([schema.MSGPACK_PROTOCOL, schema.JSON_PROTOCOL], bytes),
        (["other", schema.MSGPACK_PROTOCOL], bytes),
        (["other"], str),
    ],
)
def test_the_subprotocol_chooses_the_encoding(server, offered, kind):
    with opened(server, subprotocols=offered) as live:
        assert isinstance(live.recv(20), kind)
        # Either kind of frame is understood.
        live.send('{"type": "ping", "id": 1}')
        assert until(live, "pong")["id"] == 1
        live.send(msgspec.msgpack.encode({"type": "ping", "id": 2}))
        assert until(live, "pong")["id"] == 2


def test_subscriptions(server):
    with opened(server) as live:
        live.send('{"type": "subscribe", "parts": ["contacts"], "rate": 0, "id": 5}')
        assert until(live, "done")["id"] == 5
        with pytest.raises(TimeoutError):
            live.recv(0.2)
        live.send('{"type": "subscribe", "parts": ["objects"], "rate": 10}')
        until(live, "done")
        first, *_, last = [until(live, "frame") for _ in range(5)]
        assert last["time"] - first["time"] == pytest.approx(0.4, abs=0.05)
        assert "contacts" not in last
        assert "rotations" not in last["people"]["person0"]


def test_an_edit_is_seen_by_everybody(server):
    add = {"action": "add", "name": "b", "shape": "sphere:0.1", "mass": 1, "position": [0, 3, 1]}
    with opened(server) as one, opened(server) as other:
        one.send(json.dumps({"type": "edit", "id": "x", "edit": add}))
        assert until(one, "done")["id"] == "x"
        assert [o["name"] for o in until(other, "scene")["objects"]] == ["ball", "b"]
        assert "b" in until(other, "frame")["objects"]
        one.send(json.dumps({"type": "edit", "id": "y", "edit": add}))
        error = until(one, "error")
        assert (error["id"], error["code"]) == ("y", "refused")


def test_two_clients_do_not_move_one_person(server):
    with opened(server) as one, opened(server) as other:
        frame = until(one, "frame")
        pose = pose_of(frame)
        one.send(pose)
        one.send('{"type": "ping"}')
        until(one, "pong")
        other.send(pose)
        assert until(other, "error")["code"] == "busy"
        other.send(pose)  # said once
        other.send('{"type": "ping"}')
        assert until(other, "pong")
        one.close()
        deadline = time.monotonic() + 30.0
        stamp = None
        while stamp is None or stamp["sent"] != 5.0:  # as soon as the server has noticed
            assert time.monotonic() < deadline
            other.send(pose_of(frame, time=5.0))
            stamp = until(other, "frame")["people"]["person0"]["stamp"]


def test_a_client_without_a_name_that_exists(server):
    with opened(server) as live:
        frame = until(live, "frame")
        live.send(pose_of(frame).replace("person0", "eve"))
        error = until(live, "error")
        assert "expected one of person0, person1" in error["message"]


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "https://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "evil.example"}, 403),
    ],
)
def test_strangers_pages_are_refused(server, headers, status):
    host = headers.pop("Host", None)
    if host is not None:  # a name that points to us
        refused = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
        refused.request("GET", "/", headers={"Host": host})
        assert refused.getresponse().status == status
        return
    with pytest.raises(InvalidStatus) as caught:
        opened(server, additional_headers=headers)
    assert caught.value.response.status_code == status
    assert b"--origin" in caught.value.response.body


def test_pages(server):
    def fetched(path):
        asked = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
        asked.request("GET", path)
        answer = asked.getresponse()
        return answer.status, answer.getheader("Content-Type"), answer.read()

    assert fetched("/") == (200, "text/html", b"<html>hello")
    assert fetched("/?a=1")[0] == 200
    assert fetched("/../etc/passwd")[0] == 404
    assert b"WebSocket" in fetched("/nothing")[2]


def test_a_token(session):
    made = Server(session, Gate("127.0.0.1", "secret-12"), 0)
    made.start()
    try:
        with pytest.raises(InvalidStatus, match="401"):
            opened(made)
        with connect(f"ws://127.0.0.1:{made.port}/?token=secret-12", proxy=None) as live:
            assert json.loads(live.recv(20))["type"] == "hello"
    finally:
        made.stop()


def test_connections_are_bounded(server, monkeypatch):
    monkeypatch.setattr(module, "MOST_CLIENTS", 2)
    with opened(server) as one, opened(server) as other:
        until(one, "frame"), until(other, "frame")
        with pytest.raises(InvalidStatus, match="503"):
            opened(server)
    deadline = time.monotonic() + 20.0
    while server.clients and time.monotonic() < deadline:
        time.sleep(0.05)
    with opened(server) as live:
        assert until(live, "frame")


def test_a_client_that_does_not_read_gets_the_newest_frames_and_delays_nobody(server, monkeypatch):
    """Its buffers fill and nothing piles up behind them: frames are left out."""
    from halfphysics.live import clients

    monkeypatch.setattr(clients, "MOST_WAITING", 20_000)
    small = socket.socket()
    small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)  # the system's grow by themselves
    small.connect(("127.0.0.1", server.port))
    with (
        opened(server, max_queue=1, sock=small, close_timeout=0.2) as slow,
        opened(server) as other,
    ):
        deadline = time.monotonic() + 60.0
        while server.skipped < 20 and time.monotonic() < deadline:
            frame = until(other, "frame")
        assert server.skipped >= 20
        waiting = [c.connection.transport.get_write_buffer_size() for c in server._clients.values()]
        assert max(waiting) < 40_000
        first = until(slow, "frame")
        assert first["frame"] < frame["frame"]


def unread(server):
    """A client whose system takes little of what it does not read."""
    small = socket.socket()
    small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    small.connect(("127.0.0.1", server.port))
    return opened(server, max_queue=1, sock=small, close_timeout=0.2)


def test_answers_that_nobody_reads_do_not_pile_up_nor_delay_the_end(session):
    """Edits are not taken from who does not read their answers, 20 kB each."""
    server = Server(session, Gate("127.0.0.1"), 0)
    server.start()
    session.start()
    live, ended = unread(server), threading.Event()
    mass = {"action": "mass", "name": "nothing", "value": 1.0}

    def flood():
        with contextlib.suppress(ConnectionClosed):
            while not ended.is_set():
                live.send(json.dumps({"type": "edit", "id": 20_000 * "x", "edit": mass}))

    flooding = threading.Thread(target=flood, daemon=True)
    flooding.start()
    most, deadline = 0, time.monotonic() + 1.5
    while time.monotonic() < deadline:
        for client in list(server._clients.values()):
            most = max(most, client.connection.transport.get_write_buffer_size())
        time.sleep(0.01)
    begun = time.monotonic()
    session.stop()
    server.stop()
    assert 50_000 < most < 500_000
    assert time.monotonic() - begun < 4.0  # else until a sign of life is missed: 20 s and more
    ended.set()
    flooding.join(10.0)
    live.close()


def test_who_reads_slowly_learns_of_the_scene_later(server, session, monkeypatch):
    from halfphysics.live.clients import Client

    slow = [True]
    monkeypatch.setattr(Client, "is_slow", property(lambda client: slow[0]))
    with opened(server) as live:
        until(live, "hello")
        session.edit(schema.Mass("ball", 2.0), lambda reason: None)
        deadline = time.monotonic() + 20.0
        while not session.edited and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.1)
        slow[0] = False
        assert until(live, "scene")["objects"][0]["mass"] == 2.0


def test_those_who_do_not_read_the_first_message_are_counted(server, monkeypatch):
    monkeypatch.setattr(module, "MOST_CLIENTS", 1)
    waiting = threading.Event()

    async def never(client, message):
        waiting.set()
        await client.connection.wait_closed()

    monkeypatch.setattr("halfphysics.live.clients.Client.send", never)
    with opened(server, close_timeout=0.1):
        assert waiting.wait(20.0)
        with pytest.raises(InvalidStatus, match="503"):
            opened(server)


def test_floods_are_slowed(server, monkeypatch):
    monkeypatch.setattr(safety, "MESSAGES_PER_SECOND", 50.0)
    with opened(server) as live:
        live.send('{"type": "subscribe", "rate": 0}')
        until(live, "done")
        begun = time.monotonic()
        for _ in range(80):
            live.send('{"type": "ping"}')
        for _ in range(80):
            until(live, "pong")
        assert time.monotonic() - begun > 0.4


def test_faults_harm_nobody(server, session):
    """A sample of `campaigns.live faults`: each wrong message has one error, the rest goes on."""
    done = provoke(f"ws://127.0.0.1:{server.port}", 150)
    assert done["unanswered"] == 0
    assert done["torn message"] + done["torn handshake"] > 0
    assert session.running
    assert session.trouble == ""
    with opened(server) as live:
        frame = until(live, "frame")
        assert "ball" in frame["objects"]
        assert until(live, "frame")["frame"] > frame["frame"]


@pytest.mark.parametrize(
    ("host", "port", "error", "said"),
    [
        ("no.such.host.invalid", 0, InputError, "no address"),
        ("203.0.113.1", 0, FileError, "another address"),
    ],
)
def test_where_nobody_can_listen(session, host, port, error, said):
    with pytest.raises(error, match=said):
        Server(session, Gate(host), port).start()


def test_a_port_in_use(server, session, monkeypatch):
    other = Server(session, Gate("127.0.0.1"), server.port)
    other.start()
    assert other.port > server.port
    other.stop()
    monkeypatch.setattr(module, "_TRIES", 1)
    with pytest.raises(FileError, match="all in use"):
        Server(session, Gate("127.0.0.1"), server.port).start()


def test_stopping_closes_connections(session):
    made = Server(session, Gate("127.0.0.1"), 0)
    made.start()
    with opened(made) as live:
        live.recv(20)
        made.stop()
        with pytest.raises(ConnectionClosed):
            live.recv(20)
