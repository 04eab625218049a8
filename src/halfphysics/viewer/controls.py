"""The panel of the viewer: play, scrub, speed, step, loop, layers."""

from __future__ import annotations

import json
import math
import time
from typing import TYPE_CHECKING, Any

from halfphysics.errors import HalfPhysicsError
from halfphysics.viewer.camera import PRESETS
from halfphysics.viewer.layers import SUPPORT, hint, legend, support_legend
from halfphysics.viewer.numbers import NumbersPanel
from halfphysics.viewer.page_data import common_data
from halfphysics.viewer.plots import Plots
from halfphysics.viewer.remote import Remote
from halfphysics.viewer.server import icon
from halfphysics.viewer.stage import Layer
from halfphysics.viewer.timeline import SPEEDS

if TYPE_CHECKING:
    from halfphysics.viewer.site_root import SiteRoot
    from halfphysics.viewer.view import Viewer

# Update interval of the slider, and its pause after the user moved it [s].
_FOLLOW, _HANDS_OFF = 0.1, 0.6
# Interval between messages about the time to scripts, which go on by their own clocks [s].
_TELL = 0.5
# Step of the slider [s].
_GRAIN = 0.01
_PLAY, _PAUSE = "Play", "Pause"
_START, _BACK, _ON = "Start", "◀", "▶"


class Controls:
    """Buttons and sliders for a `Viewer`; its own thread changes the scene."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        #: Whether browsers colour the skin by force.
        self.paint = Layer("Skin by force")
        self._timeline = timeline = viewer.timeline
        self._followed = self._touched = 0.0
        gui = self._gui = viewer.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        self._time = gui.add_markdown("")
        self._slider = gui.add_slider(
            "Time [s]", 0.0, slider_end(timeline.duration), _GRAIN, 0.0, hint="Drag to any moment"
        )
        self._slider.on_update(self._scrubbed)
        self._play = gui.add_button(_PAUSE, icon=icon("PLAYER_PAUSE"), hint="Also: space")
        self._play.on_click(lambda _: self._toggle())
        self._steps = gui.add_button_group(
            "Step", (_START, _BACK, _ON), hint="One frame back or on. Also: arrow keys"
        )
        self._steps.on_click(self._stepped)
        self._speed = gui.add_slider("Speed", *SPEEDS, 0.1, timeline.speed)
        self._speed.on_update(lambda _: self._set(speed=self._speed.value))
        self._loop = gui.add_checkbox("Loop", timeline.loop)
        self._loop.on_update(lambda _: self._set(loop=self._loop.value))
        results = [stage.drawing.result for stage in viewer.stages]
        with gui.add_folder("Show", expand_by_default=False):
            self._toggles = self._add_layers()
            if any("contacts" in stage.layers for stage in viewer.stages):
                gui.add_html(legend(results))
            self._support_note = gui.add_html("", visible=False)
        with gui.add_folder("Plots", expand_by_default=False) as self._plots_folder:
            self.plots = Plots(gui, results, viewer.labels, timeline.duration)
        with gui.add_folder("Numbers", expand_by_default=False):
            self.numbers = NumbersPanel(gui, results, viewer.labels)
        with gui.add_folder("Camera", expand_by_default=False):
            self._add_camera()
        self._add_upload()
        self._add_keys()
        self._told = -math.inf
        self.remote = Remote(gui, self._obey)

    def _add_layers(self) -> list[Any]:
        viewer, gui = self._viewer, self._gui
        boxes = []
        if len(viewer.stages) > 1:
            for stage, label in zip(viewer.stages, viewer.labels, strict=True):
                box = gui.add_checkbox(label, True)
                box.on_update(self._shows([stage]))
                boxes.append(box)
            gui.add_divider()
        if any(len(stage.drawing.result.contacts.frame) for stage in viewer.stages):
            box = gui.add_checkbox("Skin by force", True, hint="From 1 N to 1 kN, logarithmic")
            box.on_update(self._shows([self.paint]))
            boxes.append(box)
        for name in dict.fromkeys(n for stage in viewer.stages for n in stage.layers):
            layers = [stage.layers[name] for stage in viewer.stages if name in stage.layers]
            box = gui.add_checkbox(layers[0].label, layers[0].visible)
            box.on_update(self._shows_support(layers) if name == SUPPORT else self._shows(layers))
            boxes.append(box)
        return boxes

    def _shows(self, items: list[Any]) -> Any:
        def shows(event: Any) -> None:
            def task() -> None:
                for item in items:
                    item.visible = event.target.value

            self._viewer.do(task)

        return shows

    def _shows_support(self, layers: list[Any]) -> Any:
        """As `_shows`. The first time it works the support out, and adds its plot and numbers."""

        def shows(event: Any) -> None:
            note = self._support_note
            if event.client_id is None:  # the task set it back
                return
            box = event.target
            if box.value and not self.plots.has_support:
                note.content, note.visible = hint("Working out what holds people up ..."), True
            self._viewer.do(lambda: task(box))

        def task(box: Any) -> None:
            note = self._support_note
            try:
                for layer in layers:
                    layer.visible = box.value
            except HalfPhysicsError as error:
                note.content, note.visible, box.value = hint(str(error)), True, False
                return
            if box.value and not self.plots.has_support:
                with self._plots_folder:
                    self.plots.add_support()
                self.numbers.add_support()
                self._followed = 0.0
            note.content, note.visible = support_legend(), box.value

        return shows

    def _add_camera(self) -> None:
        viewer, gui = self._viewer, self._gui
        views = gui.add_button_group("Look from", PRESETS, hint="At the people as they are now")

        def look(event: Any) -> None:
            client, name = event.client, views.value
            viewer.do(lambda: viewer.cameras.preset(client, name))

        def everything(event: Any) -> None:
            viewer.do(lambda: viewer.cameras.everything(event.client))

        views.on_click(look)
        reset = gui.add_button("See everything", icon=icon("HOME"), hint="The whole motion")
        reset.on_click(everything)
        follow = gui.add_checkbox(
            "Follow", viewer.cameras.following, hint="Go along; turn and zoom as you like"
        )

        def follows(_event: Any) -> None:
            viewer.cameras.following = follow.value

        follow.on_update(follows)
        self._follow = follow

    def _add_upload(self) -> None:
        """A button to open a file, the same as dropping it onto the page."""
        viewer = self._viewer
        button = self._gui.add_upload_button(
            "Open a file", icon=icon("FOLDER_OPEN"), hint="Or drop it onto the picture"
        )

        # In the event loop: in the pool of threads the next upload may have replaced the value.
        async def uploaded(event: Any) -> None:
            file = event.target.value
            viewer.do(lambda: viewer.take(file.name, file.content))

        button.on_upload(uploaded)

    def publish(self, root: SiteRoot | None, loads: int) -> None:
        """Tell browsers what they need beside the scene: marks, contacts, comparisons.

        Args:
            root: The folder that the server serves; None: browsers have no script of ours.
            loads: How often the scene was built anew; browsers load the page again with it.
        """
        if root is None:
            return
        viewer = self._viewer
        frames = [range(len(stage.drawing)) for stage in viewer.stages]
        title = " | ".join(viewer.labels)
        data = common_data(viewer.stages, viewer.labels, title, frames)
        name = root.publish(json.dumps(data, separators=(",", ":")))
        self.remote.tell(data=name, loads=loads, paint=self.paint.visible, clock=self._clock())

    def _clock(self) -> dict[str, Any]:
        timeline = self._timeline
        return {
            "time": round(timeline.time, 4),
            "playing": timeline.playing,
            "speed": timeline.speed,
            "duration": round(timeline.duration, 6),
            "fps": timeline.fps,
        }

    def _obey(self, name: str, value: Any, client: Any) -> None:
        """Execute a command of a browser's script; a value that does not fit is ignored."""
        viewer = self._viewer
        number = value if isinstance(value, int | float) and math.isfinite(value) else None
        if name == "toggle":
            self._toggle()
        elif name == "seek" and number is not None:
            self._seek(number)
        elif name == "step" and number is not None:
            self._step(int(number))
        elif name == "speed" and number is not None:
            self._set(speed=min(max(number, SPEEDS[0]), SPEEDS[1]))
            self._speed.value = self._timeline.speed
        elif name == "preset" and value in PRESETS:
            viewer.do(lambda: viewer.cameras.preset(client, value))
        elif name == "home":
            viewer.do(lambda: viewer.cameras.home(client))
        elif name == "follow":
            self._switch_follow()
        elif name == "compare":
            viewer.do(lambda: viewer.compare(client.client_id, bool(value)))

    def _switch_follow(self) -> None:
        cameras = self._viewer.cameras
        cameras.following = self._follow.value = not cameras.following
        self.remote.say("The camera follows." if cameras.following else "The camera stays.")

    def _add_keys(self) -> None:
        keys = (
            ("Play or pause", "space", self._toggle),
            ("One frame back", "arrowleft", lambda: self._step(-1)),
            ("One frame on", "arrowright", lambda: self._step(1)),
            ("To the start", "home", lambda: self._seek(0.0)),
            ("To the end", "end", lambda: self._seek(self._timeline.duration)),
            ("Follow", "F", self._switch_follow),
        )
        for label, key, action in keys:
            command = self._gui.add_command(label, hotkey=key)
            command.on_trigger(lambda _event, action=action: action())
        for k, name in enumerate(PRESETS):
            command = self._gui.add_command(f"Look from: {name}", hotkey=str(k + 1))
            command.on_trigger(lambda event, name=name: self._obey("preset", name, event.client))

    def _toggle(self) -> None:
        self._timeline.toggle()
        self._now()

    def _step(self, frames: int) -> None:
        self._timeline.step(frames)
        self._now()

    def _seek(self, time: float) -> None:
        self._timeline.seek(time)
        self._now()

    def _stepped(self, event: Any) -> None:
        if event.target.value == _START:
            self._seek(0.0)
        else:
            self._step(1 if event.target.value == _ON else -1)

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            setattr(self._timeline, name, value)
        self._now()

    def _scrubbed(self, event: Any) -> None:
        # The program moved the slider, or a browser sent what no slider has.
        if event.client_id is None or not math.isfinite(self._slider.value):
            return
        self._touched = time.monotonic()
        self._timeline.seek(self._slider.value)
        self._told = -math.inf
        self._viewer.changed()

    def _now(self) -> None:
        self._followed = 0.0
        self._told = -math.inf
        self._viewer.changed()

    def refresh(self) -> None:
        """Update time, slider, plots and numbers, a few times per second at most."""
        now = time.monotonic()
        if now - self._followed < _FOLLOW:
            return
        self._followed = now
        timeline = self._timeline
        at, playing = timeline.time, timeline.playing
        self.plots.show(at)
        self.numbers.show(timeline.frames())
        frame = int(at * timeline.fps + 1e-6)
        last = round(timeline.duration * timeline.fps)
        self._time.content = f"**{at:.2f} s** of {timeline.duration:.2f} s, frame {frame} of {last}"
        if now - self._touched > _HANDS_OFF:
            self._slider.value = min(round(at, 2), self._slider.max)
        if not playing or now - self._told > _TELL:
            self._told = now
            self.remote.tell(clock=self._clock())
        self.remote.tell(paint=self.paint.visible)
        label = _PAUSE if playing else _PLAY
        if self._play.label != label:
            self._play.label = label
            self._play.icon = icon("PLAYER_PAUSE" if playing else "PLAYER_PLAY")


def slider_end(duration: float) -> float:
    """End of the slider [s]: the last frame, rounded up to a whole step, at least one step."""
    return round(max(math.ceil(duration / _GRAIN - 1e-6), 1) * _GRAIN, 2)
