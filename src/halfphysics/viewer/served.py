"""Base of the viewers: one thread makes frames for browsers and runs tasks between frames."""

from __future__ import annotations

import contextlib
import html
import queue
import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any, Self

from halfphysics.base.copying import Bound
from halfphysics.viewer.address import announcement, url
from halfphysics.viewer.server import close_server, open_server
from halfphysics.viewer.site_root import SiteRoot

# Interval between checks for the end of waiting [s].
_LOOK = 0.1
# Longest wait for the thread to end [s].
_PATIENCE = 10.0


def _root() -> SiteRoot | None:
    """The folder to serve; None: viser is missing, which `open_server` reports."""
    try:
        return SiteRoot()
    except ImportError:
        return None


class Served(Bound, ABC):
    """A scene served to browsers until `stop`, or the end of a `with` block.

    One thread owns the scene; tasks of other threads wait until it has made its frame.

    Args:
        label: Title of the panel.
        host: Address to listen on.
        port: Port to listen on; the next free one if it is in use.

    Attributes:
        server: The viser server.
        port: The port in use.

    Raises:
        HalfPhysicsError: An invalid host or port, no port is free, viser is missing.
    """

    _WHY = "it serves pages from a thread of this process; show the result over there"
    #: Start of the announcement, before "at" and the address.
    _what: str
    #: Height in a notebook [pixels].
    _height: int

    def __init__(self, label: str, host: str, port: int) -> None:
        self._host, self._asked_port = host, port
        self._root = _root()
        try:
            self.server: Any = open_server(host, port, label=label, root=self._root)
        except BaseException:
            self._close_root()
            raise
        self.port: int = self.server.get_port()
        self._stopping = threading.Event()
        self._wake = threading.Event()
        self._tasks: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._failure: BaseException | None = None
        self._waiting = False  # whether `wait` will raise it
        self._thread = threading.Thread(target=self._run, name="halfphysics-served", daemon=True)

    # -- from any thread ---------------------------------------------------------------------

    @property
    def url(self) -> str:
        """Address to open in a browser on this machine."""
        return url(self._host, self.port)

    def announce(self) -> str:
        """The address, and how to reach it from another machine."""
        return announcement(self._what, self._host, self.port, self._asked_port)

    @property
    def _state(self) -> str:
        return "stopped" if self._stopping.is_set() else self.url

    def _repr_html_(self) -> str:
        """The page itself, for notebooks."""
        if self._stopping.is_set():
            return f"<pre>{html.escape(repr(self))}</pre>"
        frame = f'width="100%" height="{self._height}" style="border:0"'
        return f'<iframe src="{self.url}" {frame}></iframe>'

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def do(self, task: Callable[[], object]) -> None:
        """Run a task between two frames, in the thread that makes them."""
        self._tasks.put(task)
        self._wake.set()

    def stop(self) -> None:
        """Stop serving; browsers lose the connection. Further calls have no effect."""
        if self._stopping.is_set():
            return
        self._stopping.set()
        self._wake.set()
        if self._thread is not threading.current_thread():
            self._thread.join(timeout=_PATIENCE)
        close_server(self.server)
        self._close_root()

    def wait(self) -> None:
        """Wait until another thread calls `stop`, or Ctrl-C.

        Raises:
            KeyboardInterrupt: Ctrl-C; serving has been stopped.
        """
        self._waiting = True
        try:
            while not self._stopping.wait(_LOOK):
                if self._failure is not None:
                    raise self._failure
        finally:
            self.stop()

    def say(self, block: bool) -> None:
        """Print the address; with `block`, wait.

        Raises:
            KeyboardInterrupt: Ctrl-C while blocking; serving has been stopped.
        """
        print(self.announce(), flush=True)
        if not block:
            return
        try:
            print("Ctrl-C ends it", flush=True)
            self.wait()
        except KeyboardInterrupt:
            self.stop()  # Ctrl-C may come before `wait` has begun
            print("", file=sys.stderr)
            raise

    def _close_root(self) -> None:
        if self._root is not None:
            self._root.close()

    # -- by subclasses -------------------------------------------------------------------------

    @contextlib.contextmanager
    def _starting(self) -> Iterator[None]:
        """Build the first frame, then start the thread; an error closes the server."""
        try:
            yield
        except BaseException:
            close_server(self.server)
            self._close_root()
            raise
        # Wake the thread for a new browser.
        self.server.on_client_connect(lambda _: self._wake.set())
        self._thread.start()

    @abstractmethod
    def _due(self) -> float:
        """Time until the next round if no task comes [s]."""

    @abstractmethod
    def _round(self) -> None:
        """Run the waiting tasks, and make a frame if one is due."""

    def _do_tasks(self) -> None:
        """Run the tasks given to `do`, in order."""
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
            if not self._waiting:  # nobody would hear of it
                raise
