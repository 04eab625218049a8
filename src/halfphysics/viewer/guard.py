"""What a viser server lets in: requests of its own pages, and uploads up to a total size.

viser checks neither where a request comes from nor how much is being uploaded. Its web server
object is changed for that; a viser that is made otherwise goes on as it is.
"""

from __future__ import annotations

import contextlib
import http
from collections.abc import Callable, Iterator
from typing import Any

from halfphysics.live.safety import Gate

#: Bytes of all uploads that are under way, and of one part of them at most.
TOTAL = 512 * 2**20


def guard(server: Any, host: str) -> Uploads:
    """Guard a `viser.infra.WebsockServer` that has not been started.

    Args:
        server: The server.
        host: The address that it listens on.

    Returns:
        The uploads that are under way.
    """
    gate, start = Gate(host), server.start

    def guarded_start() -> None:
        with _checking(gate):
            start()

    server.start = guarded_start
    uploads = Uploads()
    handle = server._handle_incoming_message

    async def guarded_handle(client: int, message: Any) -> None:
        if uploads.welcome(client, message):
            await handle(client, message)

    server._handle_incoming_message = guarded_handle
    server.on_client_disconnect(lambda connection: uploads.forget(connection.client_id))
    return uploads


@contextlib.contextmanager
def _checking(gate: Gate) -> Iterator[None]:
    """Servers of websockets that are opened meanwhile check requests by the gate."""
    import websockets.asyncio.server as module

    theirs: Any = module.serve

    def serve(*args: Any, process_request: Any = None, **options: Any) -> Any:
        return theirs(*args, process_request=checked(gate, process_request), **options)

    module.serve = serve  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        module.serve = theirs  # type: ignore[misc]


def checked(gate: Gate, process: Callable[..., Any] | None) -> Callable[..., Any]:
    """viser's answer to a request, if the gate has nothing against it."""

    def process_request(connection: Any, request: Any) -> Any:
        refusal = gate.refusal(request.path, request.headers)
        if refusal is not None:
            return connection.respond(http.HTTPStatus(refusal.status), refusal.reason + "\n")
        return None if process is None else process(connection, request)

    return process_request


class Uploads:
    """The uploads under way: what they have said they will be, and what came."""

    def __init__(self) -> None:
        self._left: dict[str, tuple[int, int]] = {}  # transfer -> client, bytes to come

    @property
    def under_way(self) -> bool:
        """Whether anything is still to come."""
        return bool(self._left)

    def welcome(self, client: int, message: Any) -> bool:
        """Whether a message may pass: every upload has a size, and all fit `TOTAL`."""
        kind = type(message).__name__
        if kind == "FileTransferStartUpload":
            size, parts = message.size_bytes, message.part_count
            whole = isinstance(size, int) and isinstance(parts, int)
            if not whole or message.transfer_uuid in self._left:
                return False
            under_way = sum(left for _, left in self._left.values())
            if not (0 <= size <= TOTAL - under_way and 0 <= parts <= max(size, 1)):
                return False
            if parts:
                self._left[message.transfer_uuid] = (client, size)
        elif kind == "FileTransferPart":
            owner, left = self._left.get(message.transfer_uuid, (client, -1))
            left -= len(message.content)
            if owner != client or left < 0:
                return False
            if left:
                self._left[message.transfer_uuid] = (client, left)
            else:
                del self._left[message.transfer_uuid]
        return True

    def forget(self, client: int) -> None:
        """A client has gone, and what it was uploading with it."""
        self._left = {key: value for key, value in self._left.items() if value[0] != client}
