"""The part of the panel for choosing and playing: scenario, motion, speed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import Choice
from halfphysics.viewer.panel.controls import ANEW, Controls, change
from halfphysics.viewer.server import icon

_PLAY, _PAUSE = "Play", "Pause"
_AGAIN, _STEP = "Start again", "One frame"


class Player:
    """Choice of scenario and motion, play and pause, speed.

    Attributes:
        place, motion, speed, loop, frozen: Handles of viser.
    """

    def __init__(
        self, gui: Any, session: do.Session, controls: Controls, announce: Callable[[str], None]
    ) -> None:
        self._gui, self._session, self._controls = gui, session, controls
        self._announce = announce
        self._add_choice()
        self._add_buttons()
        self._add_playing()

    def refresh(self) -> None:
        """Update the label and icon of the play button."""
        label = _PAUSE if self._session.playing else _PLAY
        if self._play.label != label:
            self._play.label = label
            self._play.icon = icon("PLAYER_PAUSE" if self._session.playing else "PLAYER_PLAY")

    def _add_choice(self) -> None:
        session, gui = self._session, self._gui
        catalog = session.catalog
        self.place = gui.add_dropdown(
            "Scenario",
            catalog.scenarios,
            initial_value=session.choice.scenario,
            hint="What is around. " + ANEW,
        )
        self._controls.bind(self.place, lambda: session.choice.scenario, self._choose_place)
        self.motion = gui.add_dropdown(
            "Motion",
            catalog.motions,
            initial_value=session.choice.motion,
            hint="What the person does. " + ANEW,
        )
        self._controls.bind(self.motion, lambda: session.choice.motion, self._choose_motion)

    def _add_buttons(self) -> None:
        gui, post = self._gui, self._controls.post
        self._play = gui.add_button(_PAUSE, icon=icon("PLAYER_PAUSE"), hint="Also: space")
        self._play.on_click(lambda _: self._toggle())
        steps = gui.add_button_group("Also", (_AGAIN, _STEP))
        steps.on_click(
            lambda event: post(do.Restart() if event.target.value == _AGAIN else do.Step())
        )
        keys = (
            ("Play or pause", "space", self._toggle),
            ("One frame", "arrowright", lambda: post(do.Step())),
            ("Start again", "home", lambda: post(do.Restart())),
        )
        for label, key, action in keys:
            gui.add_command(label, hotkey=key).on_trigger(lambda _, action=action: action())

    def _add_playing(self) -> None:
        session, gui = self._session, self._gui
        self.speed = gui.add_slider(
            "Play at [×]", *do.SPEEDS, 0.05, session.speed, hint="1: the motion's own rate"
        )
        self._controls.bind(self.speed, lambda: session.speed, change("speed"))
        self.loop = gui.add_checkbox(
            "Loop", session.loop, hint="Else the last pose is held, and physics goes on"
        )
        self._controls.bind(self.loop, lambda: session.loop, change("loop"))
        self.frozen = gui.add_checkbox(
            "Hold the pose", session.frozen, hint="The motion stands still, physics goes on"
        )
        self._controls.bind(self.frozen, lambda: session.frozen, change("frozen"))

    def _toggle(self) -> None:
        self._controls.post(do.Play(not self._session.playing))

    def _choose_place(self, name: str) -> do.Command:
        self._announce(f"Preparing {name} ...")
        return do.Choose(Choice(name))

    def _choose_motion(self, name: str) -> do.Command:
        return do.Vary(motion=name)
