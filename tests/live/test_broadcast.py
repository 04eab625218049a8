"""One message for many clients, framed once."""

from __future__ import annotations

import asyncio

import pytest
from websockets.asyncio.client import connect
from websockets.asyncio.server import serve

from halfphysics.live.broadcast import broadcast


async def _received(data: bytes, text: bool, count: int) -> list[str | bytes]:
    """What `count` clients get of a message, and that a closed one harms nobody."""
    there: list = []

    async def stay(connection):
        there.append(connection)
        await connection.wait_closed()

    async with serve(stay, "127.0.0.1", 0, compression=None) as server:
        port = server.sockets[0].getsockname()[1]
        clients = [
            await connect(f"ws://127.0.0.1:{port}", compression=None) for _ in range(count + 1)
        ]
        await clients.pop().close()
        while len(there) <= count:
            await asyncio.sleep(0.001)
        broadcast(there, data, text=text)
        await there[0].send("later")  # the library's own frames go on behind ours
        got = [await client.recv() for client in clients]
        assert "later" in [await clients[0].recv()]
        for client in clients:
            await client.close()
    return got


@pytest.mark.parametrize("size", [0, 125, 126, 65535, 65536, 300_000])
def test_every_open_client_gets_the_message(size):
    """At every width of a frame's length (RFC 6455, 5.2)."""
    data = bytes(i % 251 for i in range(size))
    assert asyncio.run(_received(data, False, 3)) == [data] * 3


def test_text_arrives_as_text():
    said = "β, ½, 人" * 100
    assert asyncio.run(_received(said.encode(), True, 2)) == [said] * 2
