"""`halfphysics view ws://...` and `play ws://...`: a live session in a browser."""

from __future__ import annotations

import time
from typing import Any

from halfphysics.errors import HalfPhysicsError
from halfphysics.live.client import LiveFrame
from halfphysics.render.rasterizer import Camera
from halfphysics.viewer.arrange import arrange
from halfphysics.viewer.camera import PRESETS, Cameras
from halfphysics.viewer.coloring import RAMP
from halfphysics.viewer.contacts import ContactNodes
from halfphysics.viewer.framing import WINDOW, on_people
from halfphysics.viewer.live_dents import LiveDents
from halfphysics.viewer.live_hands import LiveHands
from halfphysics.viewer.live_panel import LivePanel
from halfphysics.viewer.live_reader import LiveReader
from halfphysics.viewer.live_scene import LivePerson, LiveTouches, drawing_of, pressures_of
from halfphysics.viewer.remote import Remote
from halfphysics.viewer.served import Served
from halfphysics.viewer.skin_forces import live_points
from halfphysics.viewer.stage import Layer, Stage, aim, light
from halfphysics.viewer.theme import add_sky
from halfphysics.viewer.wardrobe import Wardrobe

# Least time between two updates, and between looks while nobody watches [s].
_SPACING, _IDLE = 1.0 / 40.0, 0.25
# Size of the picture that decides the camera [pixels].
_PICTURE = (640, 360)


class LiveView(Served):
    """A live session, shown until `stop` or the end of a `with` block.

    Args:
        url: Address of the session, such as "ws://127.0.0.1:8765".
        hands: Objects can be dragged, their masses and frictions changed.
        host: Address to listen on.
        port: Port to listen on; the next free one if it is in use.

    Attributes:
        reader: Hears the session.
        stage: What is shown of its present scene.
        shown, skipped: Frames that were shown, and that newer ones replaced before.
        paused: The picture stands still; the session goes on.

    Raises:
        HalfPhysicsError: Nothing answers at the address, no port is free, viser is missing.
    """

    stage: Stage
    _what = "the live session is shown"
    _height = 640

    def __init__(
        self, url: str, *, hands: bool = False, host: str = "127.0.0.1", port: int = 8080
    ) -> None:
        self.reader = LiveReader(url)
        self.shown = self.skipped = 0
        self.paused = False
        self._scenes, self._frame = -1, -1
        self._last = 0.0
        self._wardrobe = Wardrobe()
        try:
            super().__init__("halfphysics live", host, port)
        except BaseException:
            self.reader.stop()
            raise
        with self._starting():
            add_sky(self.server)
            self.hands = LiveHands(self) if hands else None
            self.panel = LivePanel(self)
            self.remote = Remote(self.server.gui, self.obey)
            self._set_stage(None)
        self.reader.woken = self._wake.set

    def stop(self) -> None:
        """Stop serving and leave the session."""
        super().stop()
        self.reader.stop()
        if self.hands is not None:
            self.hands.close()

    def __repr__(self) -> str:
        return f"LiveView({self.reader.address}: {self._state})"

    # -- by its own thread -------------------------------------------------------------------

    def _due(self) -> float:
        return _SPACING if self.server.get_clients() else _IDLE

    def _round(self) -> None:
        self._do_tasks()
        now = time.monotonic()
        if now - self._last < 0.5 * _SPACING:
            return
        if self._scenes != self.reader.scenes:
            try:
                self._set_stage(self.stage)
            except HalfPhysicsError as error:
                self.panel.trouble = f"The scene cannot be drawn: {error}"
        self.cameras.watch()
        if self.server.get_clients() and not self.paused:
            self._last = now
            self._show(self.reader.frame)
        self.panel.refresh()
        self._tell()

    def _show(self, frame: LiveFrame) -> None:
        """Show a frame, if it is new."""
        if frame.frame == self._frame:
            return
        passed = max(frame.frame - self._frame, 1) if self._frame >= 0 else 1
        self.skipped += passed - 1
        self._frame = frame.frame
        self.shown += 1
        self._touches.contacts = frame.contacts
        points = []
        with self.server.atomic():
            for k, person in enumerate(self.people):
                pose = frame.poses.get(person.name)
                joints, turns = self._last_frames[k] if pose is None else person.frames(pose)
                self._last_frames[k] = joints, turns
                self.stage.pose(k, joints, turns)
                target = frame.targets.get(person.name)
                ghost = (joints, turns) if target is None else person.frames(target)
                self.stage.pose(k, *ghost, ghost=True)
                touched = self._touches.of(person.name)
                points.append(live_points(person.body, *touched, joints, turns))
            for name, place in frame.objects.items():
                if name in self._objects:
                    self.stage.place(name, *place)
            self._contacts.show(0)
            if len(self._dents):
                pressed = pressures_of(frame.pressures, self._names)
                self._dents.show(pressed, {**self._start, **frame.objects}, passed)
            self.lights.follow(self.cameras.subject())
        self.cameras.follow()
        self.remote.tell_now(points=points)

    def _set_stage(self, old: Stage | None) -> None:
        """Build the stage of the session's present people and objects, in place of an old one."""
        self._scenes = self.reader.scenes
        hello, frame = self.reader.hello, self.reader.frame
        self.people = [LivePerson(item) for item in hello.people]
        drawing = drawing_of(hello, self.people, frame)
        prefix = f"/live{self._scenes}"
        row = arrange([drawing], _PICTURE)
        with self.server.atomic():
            if old is not None:
                self.server.scene.remove_by_name(old.prefix)
            self._wardrobe.put_away()
            figure = self._wardrobe.figure
            self.stage = Stage(
                self.server,
                drawing,
                prefix,
                faint=row.faint[0],
                live=True,
                figure=figure,
                dents=False,
            )
            result = drawing.result
            self._names = result.names
            self._start = {n: (t.position[0], t.quaternion[0]) for n, t in result.objects.items()}
            self._dents = LiveDents(self.stage, result.scene, self._names, 1.0 / hello.fps)
            statics, people = [s.name for s in hello.statics], [p.name for p in self.people]
            self._touches = LiveTouches(statics, people)
            self._contacts = ContactNodes(self.server, self.stage, self._touches)
        self.stage.layers["contacts"] = Layer("Contacts", [self._contacts])
        self._objects = {name.removeprefix("object/") for name in drawing.objects}
        self._last_frames = [person.frames(frame.poses[person.name]) for person in self.people]
        self._frame = -1
        if old is None:
            self._direction = row.direction
            self.cameras = Cameras(self.server, [self.stage], self._home, row.camera)
            self.cameras.following = True
            self.lights = light(self.server, row.direction.tolist(), row.reach)
        else:
            self.cameras.stages = [self.stage]
        self._show(frame)
        if old is None:
            aim(self.server, self._home(WINDOW))
        if self.hands is not None:
            self.hands.take(hello.objects)
        self.panel.show_scene()
        self._introduce()

    def _home(self, window: tuple[int, int]) -> Camera:
        return on_people(self.cameras.people(), self._direction, window)

    # -- the script of the page --------------------------------------------------------------

    def _introduce(self) -> None:
        """Tell the script of the page who is there."""
        self.remote.tell(
            data={
                "title": f"{self.reader.address} | halfphysics",
                "ramp": [list(color) for color in RAMP],
                "people": [figure.name for figure in self.stage.people],
                "of": [],
                "skin": None,
                "compare": [],
                "dropText": "A live session takes no files: halfphysics send FILE",
            },
            marks=[],
        )

    def _tell(self) -> None:
        time_now = round(self.reader.frame.time, 2)
        self.remote.tell(
            clock={
                "live": True,
                "time": time_now,
                "playing": not self.paused,
                "speed": 1.0,
                "duration": time_now,
                "fps": self.reader.hello.fps,
            }
        )

    def obey(self, name: str, value: Any, client: Any) -> None:
        """Execute a command of a browser's script; a value that does not fit is ignored."""
        if name == "toggle":
            self.paused = not self.paused
            self._wake.set()
        elif name in ("seek", "step"):
            self.remote.say("A live session cannot go to another time.")
        elif name == "preset" and value in PRESETS:
            self.do(lambda: self.cameras.preset(client, value))
        elif name == "home":
            self.do(lambda: self.cameras.home(client))
        elif name == "follow":
            self.do(self.panel.toggle_follow)


def view_live(
    url: str,
    *,
    hands: bool = False,
    host: str = "127.0.0.1",
    port: int = 8080,
    block: bool = True,
) -> LiveView:
    """Show a live session in a browser: people, reference, objects, contacts. Prints the address.

    Args:
        url: Address of the session, such as "ws://127.0.0.1:8765".
        hands: Objects can be dragged, their masses and frictions changed.
        host, port, block: As for `view`.

    Returns:
        The running viewer with `.url` and `.stop()`; a context manager.

    Raises:
        FileError: Nothing answers there, or no port is free.
        InputError: No address of a session, or an invalid host or port.
        MissingDependencyError: viser cannot be imported.
        KeyboardInterrupt: Ctrl-C while blocking; the viewer has been stopped.
    """
    viewer = LiveView(url, hands=hands, host=host, port=port)
    viewer.say(block)
    return viewer


def is_address(text: str) -> bool:
    """Whether an argument is the address of a session rather than a file."""
    return text.startswith(("ws://", "wss://"))
