"""`halfphysics play`: an interactive simulation in a browser."""

from __future__ import annotations

import time
from typing import Any

from halfphysics.render.rasterizer import Camera
from halfphysics.render.result_meshes import Drawing
from halfphysics.simulation.dragging import draggable
from halfphysics.viewer.arrange import Arrangement, arrange
from halfphysics.viewer.camera import Cameras
from halfphysics.viewer.catalog import Catalog, Choice
from halfphysics.viewer.contacts import ContactNodes
from halfphysics.viewer.framing import WINDOW, on_people
from halfphysics.viewer.live_contacts import LiveContacts
from halfphysics.viewer.live_dents import LiveDents, unpressed
from halfphysics.viewer.live_wire import LiveWire
from halfphysics.viewer.pace import Pace
from halfphysics.viewer.panel.panel import Panel
from halfphysics.viewer.provisional import provisional
from halfphysics.viewer.served import Served
from halfphysics.viewer.session import Command, Grab, LetGo, Pull, Session
from halfphysics.viewer.stage import Layer, Stage, aim, light
from halfphysics.viewer.theme import add_sky
from halfphysics.viewer.wardrobe import Wardrobe

# Interval between checks for commands while the simulation is paused [s].
_IDLE = 0.1
# Size of the picture that decides the camera [pixels]: small, to be drawn quickly.
_PICTURE = (640, 360)
# Weight of the last frame in the moving averages of the times shown.
_SMOOTH = 0.1


class Playground(Served):
    """A running playground, stopped by `stop` or at the end of a `with` block.

    Its thread owns the session, the simulator and the scene.

    Args:
        catalog: The available choices.
        choice: The first choice to play.
        host: Address to listen on.
        port: Port to listen on; the next free one if it is in use.

    Attributes:
        session: The session. Use `post` to send it commands.
        server: The viser server.
        stage: The present stage.
        cameras: The cameras of the browsers.
        pace: Timing of the frames against real time.
        simulating, sending: Moving averages of the time per frame [s].
        updates: Number of frames shown so far.

    Raises:
        HalfPhysicsError: The first choice cannot be played, no port is free, viser is missing.
    """

    _what = "the playground is"
    _height = 640

    def __init__(
        self,
        catalog: Catalog,
        choice: Choice,
        *,
        host: str = "127.0.0.1",
        port: int = 8080,
    ) -> None:
        self.session = Session(catalog, choice)
        super().__init__("halfphysics play", host, port)
        self.pace = Pace()
        self.simulating = self.sending = 0.0
        self.updates = 0
        self.stage: Stage
        self._row: Arrangement
        self._shown: object = None
        self._story = -1
        self._place = ("", "")
        self._wardrobe = Wardrobe()
        with self._starting():
            add_sky(self.server)
            self.panel = Panel(self)
            self.wire = LiveWire(self)
            self._set_stage()
            self._show()

    # -- from any thread ---------------------------------------------------------------------

    def __repr__(self) -> str:
        return f"Playground({self._state})"

    def post(self, command: Command) -> None:
        """Queue a command for the session, to be executed before its next frame."""
        self.session.post(command)
        self._wake.set()

    # -- by its own thread -------------------------------------------------------------------

    def _due(self) -> float:
        busy = self.session.playing or self.session.stepping
        return self.pace.wait() if busy else _IDLE

    def _round(self) -> None:
        """Execute the commands, make a frame if one is due, and show the result."""
        session = self.session
        asked = session.obey()
        if session.story != self._story:
            self._set_stage()
        self._do_tasks()
        if not session.playing and not session.stepping:
            self.pace.rest()
        elif self.pace.wait() == 0.0:
            self.pace.made(1.0 / (session.fps * session.speed))
            # Not `advance`: a command posted meanwhile may start a story that needs another stage.
            if session.make() is not None:
                self.simulating += _SMOOTH * (session.seconds - self.simulating)
        self.cameras.watch()
        self._show()
        self.panel.refresh(now=asked)
        self.wire.refresh()

    def _show(self) -> None:
        """Show the frame if it is new and a browser is connected."""
        session = self.session
        if session.frame is self._shown or (self.updates and not self.server.get_clients()):
            return
        start = time.perf_counter()
        stage, frame = self.stage, session.frame
        with self.server.atomic():
            for k, (body, pose) in enumerate(zip(self._bodies, frame.poses, strict=True)):
                stage.pose(k, *body.joint_frames(pose))
                positions, quaternions = self._ghosts[k]
                stage.pose(k, positions[session.index], quaternions[session.index], ghost=True)
            for name in self._objects:
                stage.place(name, *frame.objects[name])
            self._contacts.show(0)
            if len(self._dents):
                self._dents.show(frame.soft_contacts, frame.objects)
            self.lights.follow(self.cameras.subject())
        self.wire.frame()
        self.cameras.follow()
        self._shown = frame
        self.updates += 1
        self.sending += _SMOOTH * (time.perf_counter() - start - self.sending)

    def _set_stage(self) -> None:
        """Build the stage of the present choice."""
        session = self.session
        simulator = session.simulator
        result = provisional(simulator, session.sequence.motions, session.frame.objects)
        scene = simulator.world.scene
        vars(result)["dents"] = unpressed(scene)  # as long as nothing presses
        drawing = Drawing(result)
        old = getattr(self, "stage", None)
        place = (session.choice.scenario, session.choice.motion)
        moved = place != self._place
        row = arrange([drawing], _PICTURE) if moved else self._row
        with self.server.atomic():
            if old is not None:
                self.server.scene.remove_by_name(old.prefix)
            self._wardrobe.put_away()
            self.stage = Stage(
                self.server,
                drawing,
                f"/story{session.story}",
                faint=row.faint[0],
                live=True,
                figure=self._wardrobe.figure,
                dents=False,
            )
            self._dents = LiveDents(self.stage, scene, simulator.names, 1.0 / session.fps)
            self._contacts = ContactNodes(self.server, self.stage, LiveContacts(session))
        self.stage.layers["contacts"] = Layer("Contacts", [self._contacts])
        if moved:
            # All cameras go to the new view.
            self.cameras = Cameras(self.server, [self.stage], self._home, row.camera)
            self.cameras.following = self.panel.following
            self.lights = light(self.server, row.direction.tolist(), row.reach)
        else:
            self.cameras.stages = [self.stage]
        self._row, self._story, self._shown = row, session.story, None
        if moved:
            aim(self.server, self._home(WINDOW))
        self._place = place
        self._bodies = session.simulator.bodies
        self._ghosts = [
            body.joint_frames(motion)
            for body, motion in zip(self._bodies, session.sequence.motions, strict=True)
        ]
        self._objects = [name.removeprefix("object/") for name in drawing.objects]
        for name in self._objects:
            if draggable(session.simulator, name):
                self._let_drag(name)
        self.panel.show_story()
        self.wire.new_story()

    def _home(self, window: tuple[int, int]) -> Camera:
        return on_people(self.cameras.people(), self._row.direction, window)

    def _let_drag(self, name: str) -> None:
        handle = self.stage.object(name)

        # Handled in order by the event loop: in the thread pool an end may overtake a start.
        async def dragged(event: Any) -> None:
            key = (event.client_id, name)
            if event.phase == "start":
                self.post(Grab(key, name, event.start_position, event.end_position))
            elif event.phase == "update":
                self.post(Pull(key, event.end_position))
            else:
                self.post(LetGo(key))

        handle.on_drag("left")(dragged)


def play(
    catalog: Catalog,
    choice: Choice,
    *,
    host: str = "127.0.0.1",
    port: int = 8080,
    block: bool = True,
) -> Playground:
    """Open an interactive simulation in a browser. Prints the address.

    Args:
        catalog: The available choices.
        choice: The first choice to play.
        host: Address to listen on; "0.0.0.0": any machine that can reach this one can play.
        port: Port to listen on; the next free one if it is in use, with a message.
        block: Wait until Ctrl-C; False: return at once.

    Returns:
        The running playground with `.url` and `.stop()`; a context manager.

    Raises:
        InputError: An invalid choice, host or port.
        FileError: A file cannot be used, or no port is free.
        MissingDependencyError: viser cannot be imported.
        KeyboardInterrupt: Ctrl-C while blocking; the playground has been stopped.
    """
    playground = Playground(catalog, choice, host=host, port=port)
    playground.say(block)
    return playground
