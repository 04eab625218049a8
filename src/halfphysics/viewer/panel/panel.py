"""The panel of the playground: its parts in order, cameras, layers and status."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import Option, options
from halfphysics.viewer.panel.controls import ANEW, Controls, write
from halfphysics.viewer.panel.items import ItemKnobs
from halfphysics.viewer.panel.person import PersonKnobs
from halfphysics.viewer.panel.player import Player
from halfphysics.viewer.server import icon

if TYPE_CHECKING:
    from halfphysics.viewer.playground import Playground

#: Interval between updates of the panel [s].
_FOLLOW = 0.15
#: Below this fraction of real time the panel reports slow motion.
_SLOW = 0.95


class Panel:
    """Controls for a `Playground`; their callbacks only post commands and tasks."""

    def __init__(self, playground: Playground) -> None:
        self._playground = playground
        self._session = playground.session
        self._followed = 0.0
        self._own: list[Any] = []  # handles of the present scenario
        self._layers: dict[str, bool] = {}
        self.controls = Controls(playground.post)
        gui = self._gui = playground.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        self.status = gui.add_markdown("")
        self.trouble = gui.add_markdown("", visible=False)
        self.player = Player(gui, self._session, self.controls, self._announce)
        self.items = ItemKnobs(gui, self._session, self.controls, self._choose_item)
        person = gui.add_folder("Person")
        self.scenario = gui.add_folder("Scenario")
        self.show = gui.add_folder("Show", expand_by_default=False)
        with person:
            self.person = PersonKnobs(gui, self._session, self.controls)
        with self.show:
            self._add_cameras()

    def _announce(self, text: str) -> None:
        self.trouble.content, self.trouble.visible = text, True

    # -- cameras, layers, options of the scenario --------------------------------------------

    def _add_cameras(self) -> None:
        playground, gui = self._playground, self._gui
        whole = gui.add_button("See everything", icon=icon("HOME"), hint="The whole motion")
        whole.on_click(lambda e: playground.do(lambda: playground.cameras.everything(e.client)))
        self.follow = gui.add_checkbox("Follow", True, hint="Go along; turn and zoom as you like")
        self.follow.on_update(lambda _: playground.do(self.follow_now))

    @property
    def following(self) -> bool:
        """Whether cameras follow people."""
        return bool(self.follow.value)

    def follow_now(self) -> None:
        """Let the cameras do what the checkbox says."""
        self._playground.cameras.following = self.following

    def show_story(self) -> None:
        """Build the controls of the present scenario: its objects, options and layers."""
        for handle in self._own:
            handle.remove()
        self.controls.forget(self._own)
        self._own = self.items.add()
        self._add_options()
        self._add_layers()
        self.refresh(now=True)

    def _choose_item(self, task: Callable[[], None]) -> None:
        def build() -> None:
            task()
            self.show_story()

        self._playground.do(build)

    def _add_options(self) -> None:
        found = options(self._session.choice.scenario)
        self.scenario.visible = bool(found)
        with self.scenario:
            for option in found:
                slider = self._gui.add_slider(
                    option.name.replace("_", " ").capitalize(),
                    option.low,
                    option.high,
                    option.step,
                    option.value,
                    hint=ANEW,
                )
                self.controls.bind(
                    slider, partial(self._option, option), self._choose_option(option.name)
                )
                self._own.append(slider)

    def _option(self, option: Option) -> float:
        return self._session.choice.options.get(option.name, option.value)

    def _choose_option(self, name: str) -> Callable[[Any], do.Command]:
        scenario = self._session.choice.scenario

        def chosen(value: float) -> do.Command:
            return do.Vary(options={name: value}, scenario=scenario)

        return chosen

    def _add_layers(self) -> None:
        with self.show:
            for name, layer in self._playground.stage.layers.items():
                visible = self._layers.setdefault(name, layer.visible)
                layer.visible = visible
                box = self._gui.add_checkbox(layer.label, visible)
                box.on_update(self._shows(name))
                self._own.append(box)

    def _shows(self, name: str) -> Callable[[Any], None]:
        def shows(event: Any) -> None:
            def task() -> None:
                self._layers[name] = event.target.value
                layer = self._playground.stage.layers.get(name)
                if layer is not None:
                    layer.visible = event.target.value

            self._playground.do(task)

        return shows

    # -- values of the session, shown by the playground's thread -----------------------------

    def refresh(self, now: bool = False) -> None:
        """Show the session's present values, a few times per second or `now`."""
        clock = time.monotonic()
        if not now and clock - self._followed < _FOLLOW:
            return
        self._followed = clock
        self.controls.follow(clock)
        self.person.refresh()
        self.player.refresh()
        write(self.status, self._state())
        trouble = self._session.trouble
        write(self.trouble, f"**{trouble}**" if trouble else "")
        self.trouble.visible = bool(trouble)

    def _state(self) -> str:
        session, playground = self._session, self._playground
        last = (session.frames - 1) / session.fps
        lines = [f"**{session.index / session.fps:.2f} s** of {last:.2f} s"]
        contacts = session.frame.contacts
        force = float(np.linalg.norm(contacts.impulse, axis=1).sum()) * session.fps
        if len(contacts.part):
            many = "contact" if len(contacts.part) == 1 else "contacts"
            lines[0] += f", {len(contacts.part)} {many}, {force:.0f} N"
        frame = 1e3 / (session.fps * session.speed)
        lines.append(
            f"{frame:.0f} ms a frame: physics {1e3 * playground.simulating:.1f}, "
            f"sending {1e3 * playground.sending:.1f}"
        )
        kept = playground.pace.kept
        if not session.playing:
            lines.append("Paused")
        elif kept is not None and kept < _SLOW:
            lines.append(f"**Slow motion**: {100 * kept:.0f} % of the speed set")
        elif kept is not None:
            lines.append(f"{100 * session.speed:.0f} % of real time, kept")
        return "  \n".join(lines)
