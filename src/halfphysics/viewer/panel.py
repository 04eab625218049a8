"""The panel of the playground: what to play, how, and how well the machine keeps up."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from halfphysics.settings import Settings
from halfphysics.viewer import session as do
from halfphysics.viewer.catalog import Choice, Option, options
from halfphysics.viewer.knobs import STRENGTHS, mass_of, movable
from halfphysics.viewer.server import icon

if TYPE_CHECKING:
    from halfphysics.viewer.playground import Playground

# The read-out follows this often [s], and a slider is left alone that a hand moved this lately.
_FOLLOW, _HANDS_OFF = 0.15, 0.8
_PLAY, _PAUSE = "Play", "Pause"
_AGAIN, _STEP = "Start again", "One frame"
# Part of real time under which it is called slow motion.
_SLOW = 0.95
_LIVE = "Takes effect at once"
_ANEW = "Starts from the beginning"


@dataclass(eq=False)
class _Control:
    """A handle of viser, what it should say, and when a hand moved it last [s]."""

    handle: Any
    says: Callable[[], Any]
    touched: float = -math.inf

    def __post_init__(self) -> None:
        self._put = self.handle.value

    def follow(self, now: float) -> None:
        """Shows what the session has, unless a hand is on it.

        A hand's value is in the handle before anybody is told of it: what is not what was put there
        is a hand's.
        """
        value = self.handle.value
        if value != self._put and not (value != value and self._put != self._put):  # NaN is NaN
            self._put, self.touched = value, now
        if now - self.touched > _HANDS_OFF:
            _put(self.handle, self.says())
            self._put = self.handle.value


class Panel:
    """Controls for a `Playground`; what they ask for is posted, never done by their callbacks."""

    def __init__(self, playground: Playground) -> None:
        self._playground = playground
        self._session = playground.session
        self._followed = 0.0
        self._thing = ""
        self._own: list[Any] = []
        self._layers: dict[str, bool] = {}
        self._bound: list[_Control] = []
        gui = self._gui = playground.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        self.status = gui.add_markdown("")
        self.trouble = gui.add_markdown("", visible=False)
        self._add_choice()
        self._add_player()
        self.things = gui.add_folder("Things")
        self.person = gui.add_folder("Person")
        self.scenario = gui.add_folder("Scenario")
        self.show = gui.add_folder("Show", expand_by_default=False)
        with self.person:
            self._add_person()
        with self.show:
            self._add_cameras()

    # -- building ----------------------------------------------------------------------------

    def _add_choice(self) -> None:
        session, gui = self._session, self._gui
        catalog = session.catalog
        self.place = gui.add_dropdown(
            "Scenario",
            catalog.scenarios,
            initial_value=session.choice.scenario,
            hint="What is around. " + _ANEW,
        )
        self._bind(self.place, lambda: session.choice.scenario, self._choose_place)
        self.motion = gui.add_dropdown(
            "Motion",
            catalog.motions,
            initial_value=session.choice.motion,
            hint="What the person does. " + _ANEW,
        )
        self._bind(self.motion, lambda: session.choice.motion, self._choose_motion)

    def _add_player(self) -> None:
        session, gui = self._session, self._gui
        self.play = gui.add_button(_PAUSE, icon=icon("PLAYER_PAUSE"), hint="Also: space")
        self.play.on_click(lambda _: self._toggle())
        self.steps = gui.add_button_group("Also", (_AGAIN, _STEP))
        self.steps.on_click(self._stepped)
        self.speed = gui.add_slider(
            "Play at [×]", *do.SPEEDS, 0.05, session.speed, hint="1: the motion's own rate"
        )
        self._bind(self.speed, lambda: session.speed, self._change("speed"))
        self.loop = gui.add_checkbox(
            "Loop", session.loop, hint="Else the last pose is held, and physics goes on"
        )
        self._bind(self.loop, lambda: session.loop, self._change("loop"))
        self.frozen = gui.add_checkbox(
            "Hold the pose", session.frozen, hint="The motion stands still, physics goes on"
        )
        self._bind(self.frozen, lambda: session.frozen, self._change("frozen"))
        keys = (
            ("Play or pause", "space", self._toggle),
            ("One frame", "arrowright", lambda: self._post(do.Step())),
            ("Start again", "home", lambda: self._post(do.Restart())),
        )
        for label, key, action in keys:
            gui.add_command(label, hotkey=key).on_trigger(lambda _, action=action: action())

    def _add_person(self) -> None:
        gui = self._gui
        self.stiffness = gui.add_slider(
            "Firmness λ",
            0.0,
            10.0,
            0.05,
            1.0,
            hint="0 limp (with Algorithm 1), 1 firm, 10 nearly rigid. " + _LIVE,
        )
        self._bind(self.stiffness, self._stiffness, self._turn("stiffness"))
        self.strength = gui.add_dropdown(
            "Strength", tuple(STRENGTHS), hint="What the drive can exert. " + _LIVE
        )
        self._bind(self.strength, self._strength, self._turn("strength"))
        self.drive_time = gui.add_slider(
            "Drive [s]", 0.005, 0.5, 0.005, 0.02, hint="Time constant of the drive. " + _LIVE
        )
        self._bind(self.drive_time, self._drive_time, self._turn("drive_time"))
        self.paper = gui.add_checkbox(
            "Algorithm 1", False, hint="Of the paper, instead of strength and drive. " + _LIVE
        )
        self._bind(self.paper, self._paper, self._turn("paper"))
        self.substeps = gui.add_slider(
            "Substeps", 1, 32, 1, 8, hint="Of a frame: more are more exact and slower. " + _LIVE
        )
        self._bind(self.substeps, self._substeps, self._turn("substeps"))
        self.untouched = gui.add_button(
            "As the scenario has it", hint="All of these, and those of the things"
        )
        self.untouched.on_click(lambda _: self._post(do.Untouched()))

    def _add_cameras(self) -> None:
        playground, gui = self._playground, self._gui
        self.home = gui.add_button("See everything", icon=icon("HOME"), hint="As at the start")
        self.home.on_click(lambda e: playground.do(lambda: playground.cameras.home(e.client)))
        self.follow = gui.add_checkbox("Follow", False, hint="Go along; turn and zoom as you like")
        self.follow.on_update(lambda _: playground.do(self._follow))

    @property
    def following(self) -> bool:
        """Whether cameras go along with people."""
        return bool(self.follow.value)

    def _follow(self) -> None:
        self._playground.cameras.following = self.following

    def show_story(self) -> None:
        """What is there to turn in this scenario."""
        for handle in self._own:
            handle.remove()
        self._bound = [c for c in self._bound if not any(c.handle is h for h in self._own)]
        self._own = []
        self._add_things()
        self._add_options()
        self._add_layers()
        self.refresh(now=True)

    def _add_things(self) -> None:
        names = tuple(movable(self._session.sequence.scene))
        self.things.visible = bool(names)
        self.things.label = "Things" if len(names) != 1 else f"Thing: {names[0]}"
        if not names:
            return
        if self._thing not in names:
            self._thing = names[0]
        thing = movable(self._session.sequence.scene)[self._thing]
        mass = mass_of(thing)
        with self.things:
            if len(names) > 1:
                which = self._gui.add_dropdown("Which", names, initial_value=self._thing)
                which.on_update(self._other_thing)
                self._own.append(which)
            self.mass = self._gui.add_slider(
                "Mass [kg]",
                min(0.01, mass),
                max(200.0, 20.0 * mass),
                0.01,
                mass,
                hint="Type small ones. " + _LIVE,
            )
            self._bind(self.mass, self._mass, self._turn("masses", self._thing))
            self.friction = self._gui.add_slider(
                "Friction", 0.0, 2.0, 0.01, min(thing.friction, 2.0), hint=_LIVE
            )
            self._bind(self.friction, self._friction, self._turn("frictions", self._thing))
        self._own += [self.mass, self.friction]

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
                    hint=_ANEW,
                )
                self._bind(slider, partial(self._option, option), self._choose_option(option.name))
                self._own.append(slider)

    def _add_layers(self) -> None:
        with self.show:
            for name, layer in self._playground.stage.layers.items():
                visible = self._layers.setdefault(name, layer.visible)
                layer.visible = visible
                box = self._gui.add_checkbox(layer.label, visible)
                box.on_update(self._shows(name))
                self._own.append(box)

    # -- what hands do: by threads of viser --------------------------------------------------

    def _bind(
        self, handle: Any, says: Callable[[], Any], asks: Callable[[Any], do.Command]
    ) -> None:
        """`says`: what the session has; `asks`: what a hand's new value asks for."""
        control = _Control(handle, says)
        self._bound.append(control)

        def moved(event: Any) -> None:
            if event.client_id is None:  # we moved it ourselves
                return
            control.touched = time.monotonic()
            self._post(asks(event.target.value))

        handle.on_update(moved)

    def _post(self, command: do.Command) -> None:
        self._playground.post(command)

    def _toggle(self) -> None:
        self._post(do.Play(not self._session.playing))

    def _stepped(self, event: Any) -> None:
        self._post(do.Restart() if event.target.value == _AGAIN else do.Step())

    @staticmethod
    def _turn(name: str, thing: str | None = None) -> Callable[[Any], do.Command]:
        return lambda value: do.Turn(name, value, thing)

    @staticmethod
    def _change(name: str) -> Callable[[Any], do.Command]:
        return lambda value: do.Change(name, value)

    def _choose_place(self, name: str) -> do.Command:
        self.trouble.content, self.trouble.visible = f"Preparing {name} ...", True
        return do.Choose(Choice(name))

    def _choose_motion(self, name: str) -> do.Command:
        return do.Choose(replace(self._session.choice, motion=name))

    def _choose_option(self, name: str) -> Callable[[Any], do.Command]:
        def chosen(value: float) -> do.Command:
            choice = self._session.choice
            return do.Choose(replace(choice, options={**choice.options, name: value}))

        return chosen

    def _other_thing(self, event: Any) -> None:
        def task() -> None:
            self._thing = event.target.value
            self.show_story()

        if event.client_id is not None:
            self._playground.do(task)

    def _shows(self, name: str) -> Callable[[Any], None]:
        def shows(event: Any) -> None:
            def task() -> None:
                self._layers[name] = event.target.value
                layer = self._playground.stage.layers.get(name)
                if layer is not None:
                    layer.visible = event.target.value

            self._playground.do(task)

        return shows

    # -- what the session has: by the playground's thread ------------------------------------

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

    def _option(self, option: Option) -> float:
        return self._session.choice.options.get(option.name, option.value)

    def _mass(self) -> float:
        return mass_of(movable(self._session.simulator.world.scene)[self._thing])

    def _friction(self) -> float:
        return float(movable(self._session.simulator.world.scene)[self._thing].friction)

    def refresh(self, now: bool = False) -> None:
        """Everything as the session has it; a few times a second, or at once."""
        clock = time.monotonic()
        if not now and clock - self._followed < _FOLLOW:
            return
        self._followed = clock
        session = self._session
        for control in self._bound:
            control.follow(clock)
        self.strength.disabled = self.drive_time.disabled = self._paper()
        label = _PAUSE if session.playing else _PLAY
        if self.play.label != label:
            self.play.label = label
            self.play.icon = icon("PLAYER_PAUSE" if session.playing else "PLAYER_PLAY")
        _write(self.status, self._state())
        _write(self.trouble, f"**{session.trouble}**" if session.trouble else "")
        self.trouble.visible = bool(session.trouble)

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
            lines.append(f"**Slow motion**: {100 * kept:.0f} % of what was asked")
        elif kept is not None:
            lines.append(f"{100 * session.speed:.0f} % of real time, kept")
        return "  \n".join(lines)


def _put(handle: Any, value: Any) -> None:
    """A value into a control, as near as it can show it."""
    if hasattr(handle, "min"):
        value = type(handle.value)(min(max(value, handle.min), handle.max))
    if handle.value != value:
        handle.value = value


def _write(handle: Any, text: str) -> None:
    if handle.content != text:
        handle.content = text
