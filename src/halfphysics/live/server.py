"""The WebSocket server of a live session: one thread that talks, beside the one that steps."""

from __future__ import annotations

import asyncio
import errno
import http
import logging
import socket
import threading
from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from halfphysics.errors import FileError, InputError
from halfphysics.live import schema
from halfphysics.live.broadcast import broadcast
from halfphysics.live.clients import Client
from halfphysics.live.safety import MOST_CLIENTS, MOST_WAITING, Gate, Refusal
from halfphysics.live.scene_items import person_item, scene_items
from halfphysics.live.scheduling import short_slices
from halfphysics.live.wire import frame_message

if TYPE_CHECKING:
    from websockets.http11 import Request, Response

    from halfphysics.live.incoming import Outgoing
    from halfphysics.live.session import Session

#: Watchers who are sent a frame at once; then whoever has sent a pose gets a turn.
_AT_ONCE = 16
#: Time for an opening handshake, between two signs of life, and for a closing handshake [s].
_OPENING, _ALIVE, _CLOSING = 5.0, 20.0, 1.0
#: Bytes that are read at once.
_READ = 16 * 1024
#: Ports that are tried, from the one that was asked for.
_TRIES = 50

Page = tuple[str, bytes]


class Server:
    """Serves a session until `stop`.

    Args:
        session: The session; it is started and stopped by others.
        gate: Who may connect, and the address to listen on.
        port: Port to listen on, or the next one that is free; 0: any.
        pages: Path, such as "/", -> content type and content of a page for browsers.

    Attributes:
        port: The port.
        skipped: Frames that slow clients were not sent.
        errors: Messages that were refused.
    """

    def __init__(
        self, session: Session, gate: Gate, port: int, pages: Mapping[str, Page] | None = None
    ) -> None:
        self._session, self._gate = session, gate
        self._pages = dict(pages or {})
        self.port = port
        self.skipped = self.errors = 0
        self._clients: dict[ServerConnection, Client] = {}
        self._opened = 0
        self._open: set[ServerConnection] = set()  # those too that have not read the first message
        self._newest: Outgoing | None = None
        self._handing = threading.Lock()
        self._loop: asyncio.AbstractEventLoop
        self._ending: asyncio.Event
        self._watching: asyncio.Task[None] | None = None
        self._thread: threading.Thread | None = None

    # -- from any thread -----------------------------------------------------------------

    @property
    def clients(self) -> int:
        """Number of clients that are connected."""
        return len(self._clients)

    def start(self) -> None:
        """Listen; returns when clients can connect.

        Raises:
            InputError: A name that is no address.
            FileError: An address of another machine, or no port is free.
        """
        listening = _listening(self._gate.host, self.port)
        self.port = listening.getsockname()[1]
        ready = threading.Event()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._main(listening, ready)),
            name="halfphysics-talk",
            daemon=True,
        )
        self._thread.start()
        ready.wait()
        self._session.listen(self._publish)

    def stop(self) -> None:
        """Close all connections and stop listening."""
        self._session.unlisten(self._publish)
        if self._thread is not None:
            self._loop.call_soon_threadsafe(self._ending.set)
            self._thread.join()
            self._thread = None

    def _publish(self, frame: Outgoing) -> None:
        """By the thread that steps: the newest frame; what was not sent before is forgotten."""
        with self._handing:
            waiting, self._newest = self._newest, frame
        if waiting is None:
            self._loop.call_soon_threadsafe(self._send_newest)

    # -- by the thread that talks --------------------------------------------------------

    async def _main(self, listening: socket.socket, ready: threading.Event) -> None:
        short_slices()
        self._loop, self._ending = asyncio.get_running_loop(), asyncio.Event()
        async with serve(
            self._serve,
            sock=listening,
            process_request=self._check,
            subprotocols=[schema.MSGPACK_PROTOCOL, schema.JSON_PROTOCOL],  # type: ignore[list-item]
            select_subprotocol=_protocol,
            compression=None,
            max_size=schema.MAX_MESSAGE,
            max_queue=8,
            open_timeout=_OPENING,
            ping_interval=_ALIVE,
            ping_timeout=_ALIVE,
            close_timeout=_CLOSING,
            server_header=None,
            logger=_quiet(),
        ):
            ready.set()
            await self._ending.wait()
            # A closing frame waits behind all that a client does not read, without a timeout.
            self._loop.call_later(_CLOSING, self._cut_off)

    def _cut_off(self) -> None:
        for connection in self._open:
            connection.transport.abort()

    def _check(self, connection: ServerConnection, request: Request) -> Response | None:
        refusal = self._gate.refusal(request.path, request.headers)
        if refusal is None and len(self._open) >= MOST_CLIENTS:
            refusal = Refusal(503, f"found {MOST_CLIENTS} clients, expected fewer. Try again later")
        if refusal is not None:
            return connection.respond(http.HTTPStatus(refusal.status), refusal.reason + "\n")
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return None
        return self._page(connection, request.path.partition("?")[0])

    def _page(self, connection: ServerConnection, path: str) -> Response:
        if path not in self._pages:
            return connection.respond(
                http.HTTPStatus.NOT_FOUND,
                "This is a live session of halfphysics: connect with a WebSocket\n",
            )
        kind, content = self._pages[path]
        response = connection.respond(http.HTTPStatus.OK, "")
        response.body = content
        for name, value in (("Content-Type", kind), ("Content-Length", str(len(content)))):
            del response.headers[name]
            response.headers[name] = value
        return response

    async def _serve(self, connection: ServerConnection) -> None:
        self._opened += 1
        self._open.add(connection)
        # A frame is sent when it is there, not when the one before it was acknowledged (Nagle).
        own: socket.socket = connection.transport.get_extra_info("socket")
        own.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, MOST_WAITING)
        # asyncio's own 256 KiB for every read of some 2 KB leave holes, and memory grows.
        connection.transport.max_size = _READ  # type: ignore[attr-defined]
        client = Client(connection, self._session, f"ws:{self._opened}", self._loop)
        try:
            await client.send(self._hello())
            self._clients[connection] = client
            async for data in connection:
                wait = client.budget.spend(len(data))
                if not await client.handle(data):
                    self.errors += 1
                if wait > 0.0:
                    await asyncio.sleep(wait)
        except ConnectionClosed:
            pass
        finally:
            self._open.discard(connection)
            self._clients.pop(connection, None)
            self._session.leave(client.source)

    def _hello(self) -> schema.Hello:
        from halfphysics import __version__

        simulator = self._session.simulator
        statics, objects = scene_items(simulator.world.made_of)
        people = zip(self._session.people, simulator.bodies, strict=True)
        return schema.hello(
            server=f"halfphysics {__version__}",
            fps=1.0 / simulator.dt,
            people=[person_item(name, body) for name, body in people],
            statics=statics,
            objects=objects,
            clock=self._session.newest.clock,
        )

    def _send_newest(self) -> None:
        with self._handing:
            frame, self._newest = self._newest, None
        if frame is None:
            return
        self._send_scene()
        drivers = [c for c in self._clients.values() if c.drives and c.wants(frame)]
        self._send_frame(frame, drivers)
        if self._watching is None or self._watching.done():
            watchers = [c for c in self._clients.values() if not c.drives and c.wants(frame)]
            if watchers:
                self._watching = self._loop.create_task(self._send_watchers(frame, watchers))
        else:
            self.skipped += sum(not c.drives for c in self._clients.values())

    async def _send_watchers(self, frame: Outgoing, watchers: list[Client]) -> None:
        encoded: dict[Any, bytes] = {}
        for first in range(0, len(watchers), _AT_ONCE):
            self._send_frame(frame, watchers[first : first + _AT_ONCE], encoded)
            await asyncio.sleep(0)

    def _send_frame(
        self, frame: Outgoing, clients: list[Client], encoded: dict[Any, bytes] | None = None
    ) -> None:
        """Send a frame to those who keep up; each content is encoded once."""
        encoded = {} if encoded is None else encoded
        groups: dict[Any, list[Client]] = defaultdict(list)
        for client in clients:
            if client.is_slow:
                self.skipped += 1
                continue
            client.sent(frame)
            groups[client.binary, client.wanted.content].append(client)
        for key, group in groups.items():
            if key not in encoded:
                message = frame_message(frame, group[0].wanted)
                encoded[key] = schema.encode(message, group[0].binary)
            broadcast([c.connection for c in group], encoded[key], text=not group[0].binary)

    def _send_scene(self) -> None:
        """Tell whoever does not know yet what is in the scene; who is slow, when it has read."""
        edited = self._session.edited
        behind = [c for c in self._clients.values() if c.edited != edited and not c.is_slow]
        if not behind:
            return
        message = schema.SceneMessage(*scene_items(self._session.simulator.world.made_of))
        for binary in {client.binary for client in behind}:
            some = [client for client in behind if client.binary == binary]
            data = schema.encode(message, binary)
            broadcast([client.connection for client in some], data, text=not binary)
            for client in some:
                client.edited = edited


def _protocol(connection: ServerConnection, offered: Any) -> Any:
    """The first of ours that the client offers; None: it gets JSON."""
    for name in offered:
        if name in (schema.MSGPACK_PROTOCOL, schema.JSON_PROTOCOL):
            return name
    return None


def _listening(host: str, port: int) -> socket.socket:
    """A socket that listens on the port, or on the next one that is free."""
    try:
        family = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
    except (socket.gaierror, UnicodeError):
        raise InputError(
            f"host: found {host!r}, which is no address. Use 127.0.0.1, or 0.0.0.0 for all "
            "addresses of this machine"
        ) from None
    last = min(port + _TRIES, 65536) if port else 1
    for number in range(port, last):
        try:
            return socket.create_server((host, number), family=family, backlog=256)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise FileError(
                    f"cannot listen on port {number} of {host}: {error.strerror}. Give another "
                    "address or port"
                ) from None
    raise FileError(f"ports {port} to {last - 1} of {host} are all in use. Give another port")


def _quiet() -> logging.Logger:
    """A logger for what clients do wrong: they are told, nobody else is."""
    logger = logging.getLogger("halfphysics.live.websockets")
    logger.setLevel(logging.CRITICAL)
    return logger
