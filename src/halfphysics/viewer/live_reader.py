"""Hears a live session in a thread: the newest frame counts; comes back when it is lost."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.live.client import LiveClient, LiveFrame, connect
from halfphysics.live.schema import Hello, Part

#: What is heard: everything that is drawn; of what is soft, how it is pressed, too.
_PARTS: tuple[Part, ...] = ("poses", "targets", "objects", "contacts")
_SOFT_PARTS: tuple[Part, ...] = (*_PARTS, "pressures")
# Pause before the next try to connect, between two pings, and longest wait for a frame [s].
_AGAIN, _PING, _WAIT = 1.0, 2.0, 1.0
# Frames whose rate and age are shown.
_RECENT = 180


@dataclass
class Numbers:
    """What the panel says about the connection.

    Attributes:
        heard: Frames heard.
        lost: Frames that the server made in between and did not send.
        rate: Frames heard per second.
        trip: Shortest of the last round trips [s]; None: unknown.
        age: Median time from the server's frame to here [s]; None: unknown.
        connections: How often a connection was made.
    """

    heard: int = 0
    lost: int = 0
    rate: float = 0.0
    trip: float | None = None
    age: float | None = None
    connections: int = 0
    _times: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT))
    _ages: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT))
    _trips: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=8))
    _last: int = -1

    def connected(self) -> None:
        """A new connection: clocks and numbers of frames begin anew."""
        self.connections += 1
        self._last = -1
        self._trips.clear()
        self._ages.clear()
        self._times.clear()

    def ping(self, trip: float, offset: float) -> None:
        """A round trip [s], and the server's clock less ours [s]."""
        self._trips.append((trip, offset))
        self._last = -1  # the client passes over the frames that come before the answer
        self.trip = min(self._trips)[0]

    def frame(self, frame: LiveFrame, now: float) -> None:
        """A frame arrived at `now` by our clock [s]."""
        if self._last >= 0:
            self.lost += max(frame.frame - self._last - 1, 0)
        self._last = frame.frame
        self.heard += 1
        self._times.append(now)
        passed = self._times[-1] - self._times[0]
        self.rate = (len(self._times) - 1) / passed if passed > 0.0 else 0.0
        if self._trips:
            self._ages.append(now + min(self._trips)[1] - frame.clock)
            self.age = sorted(self._ages)[len(self._ages) // 2]


class LiveReader:
    """A connection to a live session, read by its own thread.

    Args:
        url: Address of the session.
        woken: Called by the thread when there is something new.

    Attributes:
        url: As given.
        address: The same without its token.
        hello: People and scene as they are now.
        scenes: Number of changes of people or scene.
        frame: The newest frame.
        numbers: About the connection.
        trouble: Why there is no connection; "": there is one.

    Raises:
        FileError: Nothing answers at the address at first, or it refuses.
        InputError: No address, or a session of another version.
    """

    def __init__(self, url: str, woken: Callable[[], None] = lambda: None) -> None:
        self.url, self.address = url, url.partition("?")[0]
        self.woken = woken
        self.numbers = Numbers()
        self.scenes = 0
        self.trouble = ""
        self._stopping = threading.Event()
        self._client: LiveClient | None = None
        self._open()
        self._thread = threading.Thread(target=self._run, name="halfphysics-live", daemon=True)
        self._thread.start()

    hello: Hello
    frame: LiveFrame

    def stop(self) -> None:
        """Close the connection; returns when the thread has ended."""
        self._stopping.set()
        self._thread.join()

    def _open(self) -> None:
        """Connect and wait for the first frame."""
        client = connect(self.url)
        try:
            items = (*client.hello.statics, *client.hello.objects)
            client.subscribe(_PARTS if all(i.soft is None for i in items) else _SOFT_PARTS)
            self.numbers.connected()
            self._ping(client)
            self.frame = self._first(client)
        except BaseException:
            client.close()
            raise
        self._client, self.hello, self._scene = client, client.hello, client.hello.objects
        self.scenes += 1
        self.trouble = ""

    def _first(self, client: LiveClient) -> LiveFrame:
        try:
            return client.receive(timeout=_WAIT)
        except TimeoutError:
            raise FileError(f"{self.address}: no frame came within {_WAIT:g} s") from None

    def _run(self) -> None:
        pinged = time.perf_counter()
        while not self._stopping.is_set():
            if self._client is None:
                self._try_again()
                continue
            try:
                now = time.perf_counter()
                if now - pinged > _PING:
                    pinged = now
                    self._ping(self._client)
                self._hear(self._client)
            except TimeoutError:
                self._lost("no frames arrive")
            except HalfPhysicsError as error:
                self._lost(str(error))
        if self._client is not None:
            self._client.close()

    def _hear(self, client: LiveClient) -> None:
        frame = client.receive(timeout=_WAIT)
        if client.hello.objects is not self._scene:
            self._scene, self.hello = client.hello.objects, client.hello
            self.scenes += 1
        self.frame = frame
        self.numbers.frame(frame, time.perf_counter())
        self.woken()

    def _ping(self, client: LiveClient) -> None:
        self.numbers.ping(*client.ping())

    def _lost(self, why: str) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
        self.trouble = why
        self.woken()

    def _try_again(self) -> None:
        if self._stopping.wait(_AGAIN):
            return
        try:
            self._open()
        except HalfPhysicsError as error:
            self.trouble = str(error)
        self.woken()
