"""`hp.serve`: a live session with its server, its protocols and its recording."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING

from halfphysics.base.validation import file_path, is_whole, number, shown
from halfphysics.errors import InputError
from halfphysics.live.latency import Latency
from halfphysics.live.pages import pages
from halfphysics.live.recording import Recorder
from halfphysics.live.safety import Gate, token_for
from halfphysics.live.server import Server
from halfphysics.live.session import Session

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.live.incoming import Receiver, Sender
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings

#: The port that clients try first.
PORT = 8765
#: Smallest and largest number of steps per second.
RATES = (10.0, 1000.0)


def serve(
    scene: Scene | None = None,
    *,
    body: Body | Sequence[Body] | None = None,
    start: Iterable[Pose] | None = None,
    settings: Settings | None = None,
    fps: float = 90.0,
    host: str = "127.0.0.1",
    port: int = PORT,
    token: str | None = None,
    origins: Iterable[str] = (),
    record: str | os.PathLike[str] | None = None,
    listen: Iterable[str] = (),
    forward: Iterable[str] = (),
) -> LiveServer:
    """Serve a scene in real time: poses in, corrected poses, objects and contacts out.

    Args:
        scene: Statics and objects; None: an empty one.
        body: The body of the person, or a sequence, one each; None: `Body.default()`.
        start: The first people's first poses; the others stand beside each other.
        settings: See `Settings`.
        fps: Steps per second.
        host: Address to listen on; beyond this machine's loopback clients need a token.
        port: Port to listen on; the next free one if it is in use; 0: any.
        token: What clients must give; None: nothing on the loopback, else a new one.
        origins: Origins of web pages of other servers that may connect.
        record: Result file to write when the server stops; see docs/live.md.
        listen: Protocols that poses come in by as well, such as "vmc:39539"; the first is the
            first person's, and so on.
        forward: Protocols that corrected poses go out by, such as "vmc:127.0.0.1:39540", likewise.

    Returns:
        `LiveServer`, which runs until `stop` or the end of a `with` block.

    Raises:
        InputError: An impossible value.
        FileError: No port is free, or the recording cannot be written.
        MissingDependencyError: A protocol needs a package that is not installed.
    """
    fps = number(fps, "fps", least=RATES[0], most=RATES[1])
    if not is_whole(port, least=0, plain=False) or port > 65535:
        raise InputError(f"port: found {shown(port)}, expected a whole number from 0 to 65535")
    origins = _texts("origins", origins, "http://localhost:5173")
    listen = _texts("listen", listen, "vmc:39539")
    forward = _texts("forward", forward, "vmc:127.0.0.1:39540")
    path = None if record is None else file_path(record)
    gate = Gate(host, token_for(host, token), origins)
    session = Session(scene, body=body, start=start, settings=settings, fps=fps)
    if path is not None and not session.people:
        raise InputError(
            "record: found a session without people, expected at least one: a result file is of "
            "people. Give a body, or leave record away"
        )
    recorder = None if path is None else Recorder(path, session.simulator)
    return LiveServer(session, gate, int(port), recorder, listen, forward)


def _texts(what: str, given: Iterable[str], example: str) -> tuple[str, ...]:
    """Texts, in order. A text alone is refused: it is a sequence of letters, by mistake."""
    alone = isinstance(given, str | bytes) or not isinstance(given, Iterable)
    texts = () if alone else tuple(given)
    if alone or not all(isinstance(one, str) for one in texts):
        listed = [given] if isinstance(given, str) else [example]
        raise InputError(f"{what}: found {shown(given)}, expected a list, such as {listed!r}")
    return texts


class LiveServer:
    """A live session that is served; made by `serve`.

    Attributes:
        session: The session.
        server: Its WebSocket server.
        latency: How long poses took from their arrival to the step.
        recorder: The recording; None: there is none.
        receivers: What poses come in by beside the server.
    """

    def __init__(
        self,
        session: Session,
        gate: Gate,
        port: int,
        recorder: Recorder | None = None,
        listen: Sequence[str] = (),
        forward: Sequence[str] = (),
    ) -> None:
        self.session, self.recorder = session, recorder
        self.server = Server(session, gate, port, pages())
        self.latency = Latency()
        self._gate = gate
        self._running = contextlib.ExitStack()
        with contextlib.ExitStack() as started:
            if recorder is not None:
                started.callback(recorder.close)
            self._check(listen, forward)
            # In the order in which they are told: those who wait for the frame come first.
            self.server.start()
            started.callback(self.server.stop)
            for sender in self._senders(forward):
                started.callback(sender.stop)
                session.listen(sender.send)
            session.listen(self.latency.add)
            if recorder is not None:
                session.listen(recorder.add)
            self.receivers = self._receivers(listen)
            for receiver in self.receivers:
                receiver.start(session.deliver)
                started.callback(receiver.stop)
            session.start()
            started.callback(session.stop)
            self._running = started.pop_all()

    @property
    def url(self) -> str:
        """Address for clients on this machine, with the token."""
        host = self._gate.host
        host = "127.0.0.1" if host in ("", "0.0.0.0", "::") else host
        name = f"[{host}]" if ":" in host else host
        query = "" if self._gate.token is None else f"/?token={self._gate.token}"
        return f"ws://{name}:{self.server.port}{query}"

    @property
    def running(self) -> bool:
        """Whether it serves."""
        return self.session.running

    def stop(self) -> None:
        """End it: poses are no longer taken, clients are disconnected, the recording is written."""
        self._running.close()

    def __enter__(self) -> LiveServer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def __repr__(self) -> str:
        state = f"at {self.url}" if self.running else "stopped"
        return f"LiveServer({len(self.session.people)} people, {state})"

    def _check(self, listen: Sequence[str], forward: Sequence[str]) -> None:
        from halfphysics.live import protocols

        self._enough(listen, "listen")
        self._enough(forward, "forward")
        protocols.check(listen, forward)

    def _receivers(self, texts: Sequence[str]) -> list[Receiver]:
        from halfphysics.live import protocols

        people = zip(texts, self.session.people, self.session.simulator.bodies, strict=False)
        return [protocols.receiver(text, person=name, body=body) for text, name, body in people]

    def _senders(self, texts: Sequence[str]) -> Iterator[Sender]:
        """One after the other: those before one that fails are known, and stopped."""
        from halfphysics.live import protocols

        people = zip(texts, self.session.people, self.session.simulator.bodies, strict=False)
        for text, name, body in people:
            yield protocols.sender(text, person=name, body=body)

    def _enough(self, texts: Sequence[str], what: str) -> None:
        people = len(self.session.people)
        if len(texts) > people:
            raise InputError(
                f"{what}: found {len(texts)} protocols for {people} "
                f"{'person' if people == 1 else 'people'}, expected at most one for each. Give "
                "more people"
            )
