"""An interactive simulation: commands in, frames out; independent of a browser.

One thread owns the session and its `Simulator` and calls `advance`. Others call `post`.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Protocol

from halfphysics.body.body import Body
from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.simulation.dragging import Drag, draggable
from halfphysics.simulation.frame import Frame
from halfphysics.simulation.live_edits import rebuilt
from halfphysics.simulation.simulator import Simulator
from halfphysics.viewer.catalog import Catalog, Choice
from halfphysics.viewer.knobs import Knobs

if TYPE_CHECKING:
    from halfphysics.motion.pose import Pose
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.sequence import Sequence


class Command(Protocol):
    """A command to execute between two frames."""

    def do(self, session: Session) -> None:
        """Execute the command. Raises `HalfPhysicsError` if that is impossible."""


@dataclass(frozen=True)
class Choose:
    """Change the scenario, motion or options; the motion starts from the beginning."""

    choice: Choice

    def do(self, session: Session) -> None:
        session.choose(self.choice)


@dataclass(frozen=True)
class Vary:
    """Change the motion, or options, of the choice that there is then.

    Attributes:
        motion: The motion; None: as it is.
        options: Options to set.
        scenario: Whose options these are: another one is left alone. None: of any.
    """

    motion: str | None = None
    options: Mapping[str, float] = field(default_factory=dict)
    scenario: str | None = None

    def do(self, session: Session) -> None:
        now = session.choice
        if self.scenario not in (None, now.scenario):
            return
        motion = now.motion if self.motion is None else self.motion
        options = {**now.options, **self.options}
        session.choose(replace(now, motion=motion, options=options))


@dataclass(frozen=True)
class Turn:
    """Set a knob (a field of `Knobs`) now; `item` names the item of a mass or friction."""

    name: str
    value: Any
    item: str | None = None

    def do(self, session: Session) -> None:
        if self.name not in {f.name for f in fields(Knobs)}:
            raise InputError(f"play: found {self.name!r}, expected a knob")
        value = self.value
        if self.item is not None:
            if self.item not in session.names:
                return  # an item of a previous scenario
            value = {**getattr(session.knobs, self.name), self.item: value}
        session.turn(replace(session.knobs, **{self.name: value}))


@dataclass(frozen=True)
class Untouched:
    """Reset all knobs to the scenario's values."""

    def do(self, session: Session) -> None:
        session.turn(Knobs())


@dataclass(frozen=True)
class Play:
    """Play or pause."""

    playing: bool = True

    def do(self, session: Session) -> None:
        session.playing = self.playing


@dataclass(frozen=True)
class Step:
    """Make one frame, then pause."""

    def do(self, session: Session) -> None:
        session.playing = False
        session.stepping += 1


@dataclass(frozen=True)
class Restart:
    """Restart from the first frame with the present knobs."""

    def do(self, session: Session) -> None:
        session.restart()


@dataclass(frozen=True)
class Change:
    """Set `loop`, `frozen` or `speed` of the session."""

    name: str
    value: Any

    def do(self, session: Session) -> None:
        if self.name == "speed":
            session.speed = _speed(self.value)
        elif self.name in ("loop", "frozen") and isinstance(self.value, bool):
            setattr(session, self.name, self.value)
        else:
            raise InputError(f"play: found {self.name}={self.value!r}, expected loop or frozen")


@dataclass(frozen=True)
class Grab:
    """The pointer `key` grabs an object at the point `at` (3,) [m]; ignored if it is gone."""

    key: object
    name: str
    at: tuple[float, float, float]
    pointer: tuple[float, float, float]

    def do(self, session: Session) -> None:
        if draggable(session.simulator, self.name):
            drag = Drag.begin(session.simulator, self.name, self.at, self.pointer)
            session.drags[self.key] = drag


@dataclass(frozen=True)
class Pull:
    """The pointer `key` moves to `pointer` (3,) [m]; ignored if it holds no object."""

    key: object
    pointer: tuple[float, float, float]

    def do(self, session: Session) -> None:
        if self.key in session.drags:
            session.drags[self.key].follow(self.pointer)


@dataclass(frozen=True)
class LetGo:
    """The pointer `key` releases its object, which keeps its velocity."""

    key: object

    def do(self, session: Session) -> None:
        session.drags.pop(self.key, None)


def _supersedes(later: Command, command: Command) -> bool:
    """Whether `later` makes `command` unnecessary, as during the drag of a slider."""
    if isinstance(later, Turn) and isinstance(command, Turn):
        return (later.name, later.item) == (command.name, command.item)
    if isinstance(later, Pull) and isinstance(command, Pull):
        return later.key == command.key
    if isinstance(later, Vary) and isinstance(command, Vary):
        same = later.scenario == command.scenario and (later.motion or not command.motion)
        return bool(same) and later.options.keys() >= command.options.keys()
    return isinstance(later, Choose) and isinstance(command, Choose | Vary)


#: Smallest and largest speed, in multiples of the motion's own rate.
SPEEDS = (0.05, 4.0)


def _speed(value: Any) -> float:
    low, high = SPEEDS
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise InputError(f"speed: found {value!r}, expected {low:g} to {high:g}")
    return float(value)


class Session:
    """The state of the playground.

    Args:
        catalog: The available choices.
        choice: The first choice to play.

    Attributes:
        catalog, choice: The catalog, and the present choice.
        story: Number of the present simulation; every choice increases it by 1.
        sequence: The scenario's motion, scene, body and settings.
        simulator: The simulator, owned by the thread that calls `advance`.
        knobs: Values of the sliders.
        frame: The last frame.
        index: Index of the frame in the motion; stays at the last frame.
        made: Number of frames made since the start.
        playing, stepping: Whether it is playing, and the number of single frames to make.
        loop: Start again at the end; else the last pose is held and the simulation goes on.
        frozen: The reference pose is held while the simulation goes on.
        speed: Multiple of the motion's own rate.
        drags: Pointer -> drag of its object.
        trouble: Error of the last command or frame; "": none.
        seconds: Time to simulate the last frame [s].

    Raises:
        HalfPhysicsError: The first choice cannot be played.
    """

    choice: Choice
    sequence: Sequence
    simulator: Simulator
    frame: Frame
    index: int
    made: int

    def __init__(self, catalog: Catalog, choice: Choice) -> None:
        self.catalog = catalog
        self._commands: queue.SimpleQueue[Command] = queue.SimpleQueue()
        self.playing, self.stepping = True, 0
        self.loop, self.frozen, self.speed = True, False, 1.0
        self.drags: dict[object, Drag] = {}
        self.knobs = Knobs()
        self.story = -1
        self.trouble = ""
        self.seconds = 0.0
        self.choose(choice)

    # -- from any thread ---------------------------------------------------------------------

    def post(self, command: Command) -> None:
        """Queue a command to execute before the next frame; from any thread."""
        self._commands.put(command)

    # -- by its own thread -------------------------------------------------------------------

    def obey(self) -> bool:
        """Execute the posted commands; one that fails changes nothing and sets `trouble`.

        Returns:
            Whether there was a command.
        """
        commands = []
        while True:
            try:
                commands.append(self._commands.get_nowait())
            except queue.Empty:
                break
        for k, command in enumerate(commands):
            if k + 1 < len(commands) and _supersedes(commands[k + 1], command):
                continue
            try:
                command.do(self)
            except HalfPhysicsError as error:
                self.trouble = str(error)
            else:
                if not isinstance(command, Pull | LetGo):
                    self.trouble = ""
        return bool(commands)

    def advance(self) -> Frame | None:
        """Obey, then `make`."""
        self.obey()
        return self.make()

    def make(self) -> Frame | None:
        """Make the next frame; None: the session is paused, or the frame failed."""
        if not self.playing and not self.stepping:
            return None
        self.stepping = max(self.stepping - 1, 0)
        start = time.perf_counter()
        try:
            if self.at_end and self.loop and not self.frozen and not self.drags:
                self.restart()
            else:
                self._step()
        except HalfPhysicsError as error:
            self.trouble, self.playing, self.stepping = str(error), False, 0
            return None
        self.seconds = time.perf_counter() - start
        return self.frame

    def _step(self) -> None:
        index = self.index if self.frozen else min(self.index + 1, self.frames - 1)
        for drag in self.drags.values():
            drag.pull(self.simulator, self.simulator.dt)
        self.frame = self.simulator.step(self.target(index))
        self.index = index
        self.made += 1

    def choose(self, choice: Choice) -> None:
        """Play another choice from its beginning. A new scenario resets the knobs of items.

        Raises:
            HalfPhysicsError: The choice cannot be played; the session is unchanged.
        """
        sequence = self.catalog.load(choice)
        kept = getattr(self, "choice", None)
        same = kept is not None and kept.scenario == choice.scenario
        knobs = self.knobs if same else replace(self.knobs, masses={}, frictions={})
        self._begin(sequence, knobs)
        self.choice = choice
        self.story += 1

    def restart(self) -> None:
        """Restart from the first frame, as `simulate` does with these knobs."""
        self._begin(self.sequence, self.knobs, again=self._as_built)

    def turn(self, knobs: Knobs) -> None:
        """Change the knobs now; before the first step, from the start.

        Raises:
            HalfPhysicsError: An invalid value; the session is unchanged.
        """
        if knobs == self.knobs:
            return
        if self.made == 0:
            self._begin(self.sequence, knobs)
            return
        settings, scene = self._asked(self.sequence, knobs)
        old = self.simulator
        simulator = old
        if replace(settings, stiffness=1.0) != replace(old.settings, stiffness=1.0):
            simulator = Simulator(
                old.world.made_of, body=old.bodies, settings=settings, fps=self.fps
            )
            simulator.set_state(old.get_state())
        if (knobs.masses, knobs.frictions) != (self.knobs.masses, self.knobs.frictions):
            simulator.world = rebuilt(simulator.world, scene, True)
        if knobs.stiffness != self.knobs.stiffness:
            simulator.set_stiffness(settings.stiffness)
        self.simulator, self.knobs, self._as_built = simulator, knobs, False

    def _begin(self, sequence: Sequence, knobs: Knobs, again: bool = False) -> None:
        """Make the first frame. `again`: reuse the present simulator."""
        simulator = self.simulator if again else self._built(sequence, knobs)
        frame = simulator.reset([motion[0] for motion in sequence.motions])
        self.sequence, self.simulator, self.knobs, self.frame = sequence, simulator, knobs, frame
        self._as_built = True
        self.index = self.made = 0
        self.drags.clear()

    def _built(self, sequence: Sequence, knobs: Knobs) -> Simulator:
        settings, scene = self._asked(sequence, knobs)
        fps = sequence.motions[0].fps
        return Simulator(scene, body=bodies_of(sequence), settings=settings, fps=fps)

    def _asked(self, sequence: Sequence, knobs: Knobs) -> tuple[Settings, Scene]:
        settings = knobs.settings(sequence.settings, bodies_of(sequence)[0])
        return settings, knobs.scene(sequence.scene)

    # -- properties of the sequence ----------------------------------------------------------

    @property
    def fps(self) -> float:
        """Frame rate of the motion [1/s]."""
        return self.sequence.motions[0].fps

    @property
    def frames(self) -> int:
        """Number of frames of the motion."""
        return len(self.sequence.motions[0])

    @property
    def at_end(self) -> bool:
        """Whether the motion is at its last frame."""
        return self.index >= self.frames - 1

    @property
    def names(self) -> Collection[str]:
        """Names of the items that have knobs."""
        scene = self.sequence.scene
        return (*scene.statics, *scene.objects, *scene.articulated)

    def target(self, index: int) -> list[Pose]:
        """The reference poses of all people at a frame of the motion."""
        return [motion[index] for motion in self.sequence.motions]


def bodies_of(sequence: Sequence) -> list[Body]:
    """The bodies of all people; the default body if the source has none."""
    return [Body.default() if body is None else body for body in sequence.bodies]
