"""The panel of a live session: how it is connected, what is shown."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.base.short_repr import counted
from halfphysics.viewer.panel.controls import write
from halfphysics.viewer.server import icon

if TYPE_CHECKING:
    from halfphysics.viewer.live_view import LiveView

# Interval between updates [s].
_FOLLOW = 0.25


class LivePanel:
    """Controls for a `LiveView`, in whose thread all methods run.

    Attributes:
        trouble: What is wrong with the scene; "": nothing.
    """

    def __init__(self, view: LiveView) -> None:
        self._view = view
        self._layers: dict[str, bool] = {}
        self._own: list[Any] = []
        self._followed = 0.0
        self.trouble = ""
        gui = self._gui = view.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        self.status = gui.add_markdown("")
        self.warning = gui.add_markdown("", visible=False)
        if view.hands is not None:
            view.hands.add(gui)
        with gui.add_folder("Show"):
            home = gui.add_button("First view", icon=icon("HOME"), hint="Of the people now")
            home.on_click(lambda e: view.do(lambda: view.cameras.home(e.client)))
            self._follow = gui.add_checkbox("Follow", True, hint="Go along with the people")
            self._follow.on_update(lambda _: view.do(self._follow_now))
            self._show = gui.add_folder("Layers")

    def toggle_follow(self) -> None:
        """The cameras follow, or stay."""
        self._follow.value = not self._follow.value
        self._follow_now()
        self._view.remote.say("The camera follows." if self._follow.value else "The camera stays.")

    def show_scene(self) -> None:
        """Build the controls of the present scene: its layers."""
        for handle in self._own:
            handle.remove()
        self._own = []
        with self._show:
            for name, layer in self._view.stage.layers.items():
                layer.visible = self._layers.setdefault(name, layer.visible)
                box = self._gui.add_checkbox(layer.label, layer.visible)
                box.on_update(self._shows(name))
                self._own.append(box)

    def refresh(self) -> None:
        """Say how things are, a few times a second."""
        now = time.monotonic()
        if now - self._followed < _FOLLOW:
            return
        self._followed = now
        write(self.status, "  \n".join(self.lines()))
        hands = self._view.hands
        wrong = self._view.reader.trouble or self.trouble or (hands.trouble if hands else "")
        write(self.warning, f"**{wrong}**" if wrong else "")
        self.warning.visible = bool(wrong)

    def lines(self) -> list[str]:
        """The connection, its latency and drops, the people, the contacts."""
        view = self._view
        reader, numbers = view.reader, view.reader.numbers
        late = "" if numbers.age is None else f", {1e3 * max(numbers.age, 0.0):.1f} ms old"
        trip = "" if numbers.trip is None else f", round trip {1e3 * numbers.trip:.1f} ms"
        lines = [
            f"**{reader.address}**",
            f"{numbers.rate:.0f} of {reader.hello.fps:.0f} frames/s heard{late}{trip}",
            f"lost {numbers.lost}, not shown {view.skipped}, shown {view.shown}",
        ]
        if view.paused:
            lines.append("The picture stands still; the session goes on")
        frame = reader.frame
        for person in view.people:
            skin = "" if person.own_skin else ", drawn with the default skin"
            lines.append(f"{person.name}: {frame.tracking.get(person.name, 'live')}{skin}")
        if frame.contacts:
            force = float(np.linalg.norm([c.force for c in frame.contacts], axis=1).sum())
            lines.append(f"{counted(len(frame.contacts), 'contact')}, {force:.0f} N")
        return lines

    def _follow_now(self) -> None:
        self._view.cameras.following = bool(self._follow.value)

    def _shows(self, name: str) -> Callable[[Any], None]:
        def shows(event: Any) -> None:
            def task() -> None:
                self._layers[name] = event.target.value
                layer = self._view.stage.layers.get(name)
                if layer is not None:
                    layer.visible = event.target.value

            self._view.do(task)

        return shows
