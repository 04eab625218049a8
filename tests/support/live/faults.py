"""Clients that do everything wrong: malformed, oversized, half and late messages, torn sockets."""

from __future__ import annotations

import json
import random
import socket
from collections import Counter
from urllib.parse import urlsplit

import msgspec
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import connect

from halfphysics.live import schema

_ZEROS = [[0.0, 0.0, 0.0]] * 55
_STANDING = [[1.5708, 0.0, 0.0], *_ZEROS[1:]]


def _pose(**changes) -> dict:
    person = {"translation": [0, 0, 1.2], "rotations": _STANDING, **changes}
    return {"type": "pose", "people": {"nobody": person}, "time": 1.0}


def _edit(action: str, **fields) -> dict:
    return {"type": "edit", "id": 1, "edit": {"action": action, **fields}}


#: Messages that must be answered by one error each.
WRONG = {
    "no json": "{",
    "no object": "[]",
    "nothing": "",
    "deep": "[" * 20_000,
    "number": "1e999",
    "no type": "{}",
    "other type": json.dumps({"type": "launch"}),
    "nan": json.dumps(_pose(translation=[float("nan"), 0, 0])),
    "nan, binary": msgspec.msgpack.encode(_pose(translation=[float("nan"), 0.0, 0.0])),
    "infinite, binary": msgspec.msgpack.encode(_pose(rotations=[[float("inf")] * 3] * 55)),
    "far": json.dumps(_pose(translation=[1e6, 0, 0])),
    "degrees": json.dumps(_pose(rotations=[[90.0, 0, 0]] * 55)),
    "short": json.dumps(_pose(rotations=_ZEROS[:54])),
    "text": json.dumps(_pose(translation="here")),
    "many people": json.dumps({"type": "pose", "people": {str(i): {} for i in range(99)}}),
    "nobody": json.dumps(_pose()),
    "half, binary": msgspec.msgpack.encode(_pose())[:100],
    "bytes": bytes(range(256)),
    "surrogates": '{"type": "pose", "people": {"\\ud800": 1}}',
    "version": json.dumps({"type": "hello", "version": 99}),
    "no such object": json.dumps(_edit("mass", name="moon", value=1.0)),
    "no mass": json.dumps(_edit("mass", name="ball", value=-1.0)),
    "nan mass": msgspec.msgpack.encode(_edit("mass", name="ball", value=float("nan"))),
    "remove a wall": json.dumps(_edit("remove", name="left_wall")),
    "file": json.dumps(_edit("add", name="a", shape="/etc/passwd", mass=1, position=[0, 0, 1])),
    "comma": json.dumps(
        _edit("add", name="a", shape="sphere:1,scale=1e9", mass=1, position=[0, 0, 1])
    ),
    "no rotation": json.dumps(
        _edit("add", name="a", shape="box:1:1:1", mass=1, position=[9, 9, 1], quaternion=[0] * 4)
    ),
    "nan push": msgspec.msgpack.encode(
        _edit("impulse", name="ball", impulse=[float("nan"), 0.0, 0.0])
    ),
    "huge push": json.dumps(_edit("drag", name="left_wall", pointer=[0, 0, 1])),
    "stiffness": json.dumps(_edit("stiffness", value={"tail": 1.0})),
    "rate": json.dumps({"type": "subscribe", "rate": -1}),
}


def provoke(url: str, count: int, seed: int = 0) -> Counter:
    """Do so many things wrong, in random order.

    Returns:
        How often each kind was done, and "unanswered": wrong messages without an error.
    """
    random_ = random.Random(seed)
    done: Counter = Counter()
    while done.total() - done["unanswered"] < count:
        kind = random_.choices(("messages", "torn", "rude", "late"), (20, 3, 2, 1))[0]
        try:
            {"messages": _messages, "torn": _torn, "rude": _rude, "late": _late}[kind](
                url, random_, done
            )
        except (ConnectionClosed, InvalidHandshake, OSError, TimeoutError) as error:
            done[f"cut off ({type(error).__name__})"] += 1
    return done


def _open(url: str):
    live = connect(url, compression=None, max_size=None, proxy=None, open_timeout=60)
    live.recv(60)
    live.send(json.dumps({"type": "subscribe", "rate": 0}))
    return live


def _messages(url: str, random_: random.Random, done: Counter) -> None:
    """Wrong messages, each answered by one error; then the same connection still works."""
    with _open(url) as live:
        for name in random_.choices(list(WRONG), k=20):
            live.send(WRONG[name])
            done[name] += 1
            if _next(live)["type"] != "error":
                done["unanswered"] += 1
        live.send('{"type": "ping", "id": 7}')
        assert _next(live) == {"type": "pong", "id": 7, "time": None, "clock": _Any()}


class _Any:
    def __eq__(self, other: object) -> bool:
        return True


def _next(live) -> dict:
    """The next message that is not a frame, nor the answer to the subscription."""
    while True:
        message = json.loads(live.recv(60))
        if message["type"] not in ("frame", "done", "scene"):
            return message


def _torn(url: str, random_: random.Random, done: Counter) -> None:
    """A socket that is closed in the middle of the handshake, a frame or a message."""
    where = urlsplit(url)
    with socket.create_connection((where.hostname, where.port), timeout=10) as own:
        hello = (
            f"GET /?{where.query} HTTP/1.1\r\nHost: {where.hostname}:{where.port}\r\nUpgrade: "
            "websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n"
        ).encode()
        cut = random_.random() < 0.4
        own.sendall(hello[: random_.randrange(len(hello))] if cut else hello)
        if not cut:
            own.recv(4096)
            frame = b"\x81\xfe\x10\x00" + bytes(4) + b"{" * random_.randrange(2000)
            own.sendall(frame[: random_.randrange(len(frame))])
        if random_.random() < 0.5:  # reset rather than closed
            own.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\0\0\0\0\0\0\0")
        done["torn handshake" if cut else "torn message"] += 1


def _rude(url: str, random_: random.Random, done: Counter) -> None:
    """What breaks the protocol of WebSockets: the server closes."""
    where = urlsplit(url)
    kind = random_.choice(("oversized", "unmasked", "http", "noise"))
    done[kind] += 1
    if kind == "oversized":
        with _open(url) as live:
            live.send("x" * (schema.MAX_MESSAGE + 1))
            while True:  # until it is closed
                live.recv(60)
    with socket.create_connection((where.hostname, where.port), timeout=10) as own:
        if kind == "http":
            own.sendall(b"GET /%s HTTP/1.1\r\nHost: evil.example\r\n\r\n" % (b"a" * 9000))
        elif kind == "noise":
            own.sendall(random_.randbytes(3000))
        else:
            own.sendall(b"\x81\x02{}")
        while own.recv(4096):
            pass


def _late(url: str, random_: random.Random, done: Counter) -> None:
    """Poses of a person in the wrong order, twice, and of somebody else's person."""
    with _open(url) as live:
        for _ in range(10):
            message = _pose()
            message["people"] = {"person0": message["people"]["nobody"]}
            message["time"] = random_.choice([5.0, 4.9, 4.8, 5.0, -1e300])
            live.send(json.dumps(message))
            done["out of order"] += 1
