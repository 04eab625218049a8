"""What browsers are shown by one thread, which makes frames and does in between what is asked."""

from __future__ import annotations

import contextlib
import html
import queue
import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any, Self

from halfphysics.viewer.address import announcement, url
from halfphysics.viewer.server import close_server, open_server

# A look at whether to stop waiting [s].
_LOOK = 0.1
# The thread is given so long to end [s].
_PATIENCE = 10.0


class Served(ABC):
    """Shown in browsers until `stop`, or the end of a `with` block.

    One thread owns all that is shown; what others ask for waits until it has made its frame.

    Args:
        label: Title of the panel.
        host: Address to listen on.
        port: Port to listen on; where it is in use, the next one that is free.

    Attributes:
        server: Of viser.
        port: That it listens on.

    Raises:
        HalfPhysicsError: An impossible host or port, no port can be had, viser is missing.
    """

    #: What it is, for the line that says where.
    _what: str
    #: Of it in a notebook [pixels].
    _height: int

    def __init__(self, label: str, host: str, port: int) -> None:
        self._host, self._asked_port = host, port
        self.server: Any = open_server(host, port, label=label)
        self.port: int = self.server.get_port()
        self._stopping = threading.Event()
        self._wake = threading.Event()
        self._tasks: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="halfphysics-served", daemon=True)

    # -- from any thread ---------------------------------------------------------------------

    @property
    def url(self) -> str:
        """Address to open in a browser on this machine."""
        return url(self._host, self.port)

    def announce(self) -> str:
        """Where it can be seen, and how from another machine."""
        return announcement(self._what, self._host, self.port, self._asked_port)

    @property
    def _state(self) -> str:
        return "stopped" if self._stopping.is_set() else self.url

    def _repr_html_(self) -> str:
        """In a notebook: the page itself."""
        if self._stopping.is_set():
            return f"<pre>{html.escape(repr(self))}</pre>"
        frame = f'width="100%" height="{self._height}" style="border:0"'
        return f'<iframe src="{self.url}" {frame}></iframe>'

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def do(self, task: Callable[[], object]) -> None:
        """Have something done between two frames, by the thread that makes them."""
        self._tasks.put(task)
        self._wake.set()

    def stop(self) -> None:
        """End it; browsers see that it has gone. Once is enough, twice does no harm."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        self._wake.set()
        if self._thread is not threading.current_thread():
            self._thread.join(timeout=_PATIENCE)
        close_server(self.server)

    def wait(self) -> None:
        """Until `stop` is called elsewhere, or Ctrl-C.

        Raises:
            KeyboardInterrupt: Ctrl-C; it has been stopped.
        """
        try:
            while not self._stopping.wait(_LOOK):
                if self._failure is not None:
                    raise self._failure
        finally:
            self.stop()

    def say(self, block: bool) -> None:
        """Print where it can be seen; `block`: and wait.

        Raises:
            KeyboardInterrupt: Ctrl-C while it blocks; it has been stopped.
        """
        print(self.announce(), flush=True)
        if not block:
            return
        print("Ctrl-C ends it", flush=True)
        try:
            self.wait()
        except KeyboardInterrupt:
            print("", file=sys.stderr)
            raise

    # -- by those that are shown ---------------------------------------------------------------

    @contextlib.contextmanager
    def _starting(self) -> Iterator[None]:
        """The first frame is built; then the thread begins. What fails leaves nothing open."""
        try:
            yield
        except BaseException:
            close_server(self.server)
            raise
        # A browser has come: show it everything, now.
        self.server.on_client_connect(lambda _: self._wake.set())
        self._thread.start()

    @abstractmethod
    def _due(self) -> float:
        """How long there is nothing to do if no request comes [s]."""

    @abstractmethod
    def _round(self) -> None:
        """One look at what is to be done, and a frame if one is due."""

    def _do_tasks(self) -> None:
        """What was asked for by `do`, in that order."""
        while True:
            try:
                task = self._tasks.get_nowait()
            except queue.Empty:
                return
            task()

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._wake.wait(self._due())
                self._wake.clear()
                self._round()
        except BaseException as error:
            self._failure = error
