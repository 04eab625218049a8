"""What `play ws://...` does to a live session: objects dragged, masses and frictions changed."""

from __future__ import annotations

import queue
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from halfphysics.errors import FileError, HalfPhysicsError
from halfphysics.live.client import LiveClient, connect
from halfphysics.live.schema import Action, Drag, Friction, Mass, SceneItem

if TYPE_CHECKING:
    from halfphysics.viewer.live_view import LiveView

# The thread looks this often whether it is to end [s].
_LOOK = 0.2


class LiveHands:
    """Edits of a live session, sent by a thread over a connection of their own.

    Of the pointer's moves the newest counts.

    Args:
        view: The viewer.

    Attributes:
        trouble: Why the last edit was refused; "": it was not.

    Raises:
        FileError: Nothing answers at the address, or it refuses.
    """

    def __init__(self, view: LiveView) -> None:
        self._view = view
        self.trouble = ""
        self._objects: dict[str, SceneItem] = {}
        self._asked: queue.SimpleQueue[Action] = queue.SimpleQueue()
        self._ending = threading.Event()
        self._client: LiveClient | None = self._connected()
        self._thread = threading.Thread(target=self._run, name="halfphysics-hands", daemon=True)
        self._thread.start()

    def add(self, gui: Any) -> None:
        """Add the controls to the panel."""
        with gui.add_folder("Objects") as self._folder:
            self._which = gui.add_dropdown("Which", ("",))
            self._mass = gui.add_slider("Mass [kg]", 0.01, 200.0, 0.01, 1.0)
            self._friction = gui.add_slider("Friction", 0.0, 2.0, 0.01, 0.8)
        self._which.on_update(lambda _: self._read())
        self._mass.on_update(self._turned(lambda name, value: Mass(name, value)))
        self._friction.on_update(self._turned(lambda name, value: Friction(name, value)))

    def take(self, objects: Sequence[SceneItem]) -> None:
        """The objects of the present scene: those with a mass can be dragged."""
        self._objects = {item.name: item for item in objects if item.mass > 0.0}
        for name in self._objects:
            self._let_drag(name)
        if not hasattr(self, "_folder"):
            return
        self._folder.visible = bool(self._objects)
        if self._objects:
            self._which.options = tuple(self._objects)
            self._read()

    def close(self) -> None:
        """Let go of everything and close the connection."""
        self._ending.set()
        self._thread.join()
        self._leave()

    # -- inside ------------------------------------------------------------------------------

    def _connected(self) -> LiveClient:
        client = connect(self._view.reader.url)
        try:
            client.subscribe(rate=0.0)
        except BaseException:
            client.close()
            raise
        return client

    def _read(self) -> None:
        item = self._objects.get(self._which.value)
        if item is not None:
            self._mass.value, self._friction.value = item.mass, min(item.friction, 2.0)

    def _turned(self, action: Any) -> Any:
        def turned(event: Any) -> None:
            # Values that we write ourselves come without a browser.
            if event.client_id is not None and self._which.value in self._objects:
                self._asked.put(action(self._which.value, float(event.target.value)))

        return turned

    def _let_drag(self, name: str) -> None:
        # Handled in order by the event loop: in the thread pool an end may overtake a start.
        async def dragged(event: Any) -> None:
            pointer = tuple(float(x) for x in event.end_position)
            if event.phase == "start":
                grip = tuple(float(x) for x in event.start_position)
                self._asked.put(Drag(name, pointer, grip))  # type: ignore[arg-type]
            else:
                end = None if event.phase == "end" else pointer
                self._asked.put(Drag(name, end))  # type: ignore[arg-type]

        self._view.stage.object(name).on_drag("left")(dragged)

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                actions = [self._asked.get(timeout=_LOOK)]
            except queue.Empty:
                continue
            while not self._asked.empty():
                actions.append(self._asked.get())
            for action in newest(actions):
                self._send(action)

    def _send(self, action: Action) -> None:
        try:
            if self._client is None:
                self._client = self._connected()
            self._client.edit(action)
            self.trouble = ""
        except HalfPhysicsError as error:
            self.trouble = str(error)
            if isinstance(error, FileError):  # a new connection for the next edit
                self._leave()

    def _leave(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None


def newest(actions: Sequence[Action]) -> list[Action]:
    """Without moves and values that the next action replaces."""
    return [
        action
        for k, action in enumerate(actions)
        if k + 1 == len(actions) or not _replaces(actions[k + 1], action)
    ]


def _replaces(later: Action, action: Action) -> bool:
    """Whether the next action makes one unnecessary."""
    if isinstance(later, Drag) and isinstance(action, Drag):
        moves = action.pointer is not None and action.grip is None
        return moves and later.name == action.name
    if isinstance(later, Mass) and isinstance(action, Mass):
        return later.name == action.name
    if isinstance(later, Friction) and isinstance(action, Friction):
        return later.name == action.name
    return False
