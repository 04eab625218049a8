"""One message for many clients: it is framed once, and the same bytes are written to each.

`websockets.broadcast` frames a message anew for everybody, which for a hundred watchers costs more
than sending it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from websockets.frames import Frame, Opcode
from websockets.protocol import State

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection


def broadcast(connections: Iterable[ServerConnection], data: bytes, *, text: bool) -> None:
    """Write a message to all connections that are open, without waiting for any.

    To be called by the thread of their loop. They were opened without extensions, and nobody sends
    them a message in fragments: whole frames may then follow one another in any order.

    Args:
        connections: The connections.
        data: The message: UTF-8 if `text`.
        text: As a text frame, else as a binary one.
    """
    kind = Opcode.TEXT if text else Opcode.BINARY
    framed = Frame(kind, data).serialize(mask=False)
    for connection in connections:
        if connection.protocol.state is State.OPEN:
            connection.transport.write(framed)
