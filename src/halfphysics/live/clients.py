"""One client of the server: what it wants, and what its messages do."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any

from websockets.exceptions import ConnectionClosed
from websockets.protocol import State

from halfphysics.errors import InputError
from halfphysics.live import schema
from halfphysics.live.safety import MOST_WAITING, Budget
from halfphysics.live.wire import Subscription, incoming_poses

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection

    from halfphysics.live.incoming import Outgoing
    from halfphysics.live.session import Session

#: Edits of one client whose answers were not sent yet; it is not read from until there are fewer.
_OWED = 16
#: How often it is looked for that [s].
_LOOK = 0.005

logger = logging.getLogger(__name__)


class Client:
    """A client that is connected.

    Args:
        connection: Its connection.
        session: The session.
        source: Its name for the session.
        loop: The loop of the thread that talks.

    Attributes:
        binary: It is answered in MessagePack.
        wanted: What it wants of frames.
        drives: It has sent a pose.
        budget: What it may send.
        edited: The number of changes of the scene's items that it was told of.
    """

    def __init__(
        self,
        connection: ServerConnection,
        session: Session,
        source: str,
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        self.connection, self.source = connection, source
        self.binary = connection.subprotocol == schema.MSGPACK_PROTOCOL
        self.wanted = Subscription()
        self.drives = False
        self.budget = Budget()
        self._session, self._loop = session, loop
        self.edited = session.edited
        self._owed = 0  # answers to edits
        self._next = 0.0  # time of the next frame, where it wants fewer
        self._busy: frozenset[str] = frozenset()  # people whom somebody else drives

    @property
    def is_slow(self) -> bool:
        """Whether it reads so slowly that frames would pile up."""
        return self.connection.transport.get_write_buffer_size() > MOST_WAITING

    def wants(self, frame: Outgoing) -> bool:
        """Whether this frame is to be sent."""
        rate = self.wanted.rate
        return rate is None or (rate > 0.0 and frame.time >= self._next)

    def sent(self, frame: Outgoing) -> None:
        """A frame was sent."""
        if self.wanted.rate:
            self._next = max(self._next, frame.time - 0.5 * frame.dt) + 1.0 / self.wanted.rate

    async def send(self, message: Any) -> None:
        """Send a message; waits while the client does not read."""
        data = schema.encode(message, self.binary)
        await self.connection.send(data, text=not self.binary)

    async def handle(self, data: str | bytes) -> bool:
        """Do what a message says; returns whether it was fine, else the client was told."""
        try:
            message = schema.from_client(data)
        except InputError as error:
            await self.send(schema.ErrorMessage("invalid", str(error), schema.number_of(data)))
            return False
        match message:
            case schema.PoseMessage():
                return await self._poses(message)
            case schema.Edit(edit=action, id=key):
                await self._reads()
                self._owed += 1
                self._session.edit(action, self._answer(key), self.source)
            case schema.Subscribe(id=key):
                self.wanted, self._next = Subscription.of(message), 0.0
                await self.send(schema.Done(key))
            case schema.Ping(id=key, time=time):
                await self.send(schema.Pong(key, time, self._session.now()))
            case schema.ClientHello(version=version, name=name):
                return await self._hello(version, name)
        return True

    async def _poses(self, message: schema.PoseMessage) -> bool:
        self.drives = True
        reasons = self._session.offer_all(incoming_poses(message, self.source))
        refused = {
            name: why for name, why in zip(message.people, reasons, strict=True) if why is not None
        }
        busy = frozenset(name for name, why in refused.items() if why == "busy")
        told, self._busy = self._busy, busy
        unknown = sorted(name for name, why in refused.items() if why == "unknown")
        if unknown:
            await self.send(
                schema.ErrorMessage(
                    "refused",
                    f"pose: found person {unknown[0]!r}, expected one of "
                    f"{', '.join(self._session.people)}",
                )
            )
        elif busy - told:  # said once, not with every frame
            name = sorted(busy)[0]
            await self.send(
                schema.ErrorMessage(
                    "busy", f"pose: another client moves {name}. Move somebody else, or try later"
                )
            )
        return not unknown

    async def _hello(self, version: int, name: str) -> bool:
        if version == schema.VERSION:
            logger.info("client %s is %r", self.source, name)
            return True
        said = f"hello: found version {version}, expected {schema.VERSION}"
        await self.send(schema.ErrorMessage("version", said))
        return False

    def _answer(self, key: schema.Id) -> Any:
        """What the thread that steps calls when an edit is done or refused."""

        def answer(reason: str | None) -> None:
            done: Any = schema.Done(key)
            if reason is not None:
                done = schema.ErrorMessage("refused", reason, key)
            asyncio.run_coroutine_threadsafe(self._quietly(done), self._loop)

        return answer

    async def _reads(self) -> None:
        """Return when the client has read most of its answers, so that they do not pile up."""
        while self._owed >= _OWED and self.connection.protocol.state is State.OPEN:
            await asyncio.sleep(_LOOK)

    async def _quietly(self, message: Any) -> None:
        try:
            await self.send(message)
        except ConnectionClosed:
            logger.debug("client %s left before its answer", self.source)
        finally:
            self._owed -= 1
