"""The part of the panel with a person's knobs: stiffness, strength, drive, substeps."""

from __future__ import annotations

from typing import Any

from halfphysics.settings import Settings
from halfphysics.viewer import session as do
from halfphysics.viewer.knobs import STRENGTHS
from halfphysics.viewer.panel.controls import LIVE, Controls, turn


class PersonKnobs:
    """Knobs of the person.

    Attributes:
        stiffness, strength, drive_time, paper, substeps, untouched: Handles of viser.
    """

    def __init__(self, gui: Any, session: do.Session, controls: Controls) -> None:
        self._session, self._controls = session, controls
        self._add_drive(gui)
        self._add_algorithm(gui)

    def refresh(self) -> None:
        """Disable strength and time constant with Algorithm 1, which has neither."""
        self.strength.disabled = self.drive_time.disabled = self._paper()

    def _add_drive(self, gui: Any) -> None:
        self.stiffness = gui.add_slider(
            "Stiffness λ",
            0.0,
            10.0,
            0.05,
            1.0,
            hint="0 limp (with Algorithm 1), 1 stiff, 10 nearly rigid. " + LIVE,
        )
        self._controls.bind(self.stiffness, self._stiffness, turn("stiffness"))
        self.strength = gui.add_dropdown(
            "Strength", tuple(STRENGTHS), hint="What the drive can exert. " + LIVE
        )
        self._controls.bind(self.strength, self._strength, turn("strength"))
        self.drive_time = gui.add_slider(
            "Drive [s]", 0.005, 0.5, 0.005, 0.02, hint="Time constant of the drive. " + LIVE
        )
        self._controls.bind(self.drive_time, self._drive_time, turn("drive_time"))

    def _add_algorithm(self, gui: Any) -> None:
        self.paper = gui.add_checkbox(
            "Algorithm 1", False, hint="Of the paper, instead of strength and drive. " + LIVE
        )
        self._controls.bind(self.paper, self._paper, turn("paper"))
        self.substeps = gui.add_slider(
            "Substeps", 1, 32, 1, 8, hint="Of a frame: more are more exact and slower. " + LIVE
        )
        self._controls.bind(self.substeps, self._substeps, turn("substeps"))
        self.untouched = gui.add_button(
            "As the scenario has it", hint="All of these, and those of the things"
        )
        self.untouched.on_click(lambda _: self._controls.post(do.Untouched()))

    @property
    def _settings(self) -> Settings:
        return self._session.simulator.settings

    def _stiffness(self) -> float:
        knob, own = self._session.knobs.stiffness, self._session.sequence.settings.stiffness
        if knob is not None:
            return knob
        return float(own) if isinstance(own, int | float) else 1.0

    def _strength(self) -> str:
        knob = self._session.knobs.strength
        if knob is not None:
            return knob
        return "human" if self._session.sequence.settings.strength == "human" else "unlimited"

    def _drive_time(self) -> float:
        knob = self._session.knobs.drive_time
        return knob or self._session.sequence.settings.drive_time or Settings().drive_time or 0.0

    def _paper(self) -> bool:
        return self._settings.drive_time is None

    def _substeps(self) -> int:
        return self._settings.substeps_for(self._session.simulator.dt)
