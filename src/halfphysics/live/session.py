"""A live session: a simulator that is stepped in real time towards the poses that arrive.

One thread steps; `deliver`, `edit` and `listen` may be called from any thread. A step takes the
newest pose of everybody, makes the frame, and hands it to the listeners, which must not block.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from halfphysics.base.validation import shown
from halfphysics.errors import HalfPhysicsError, InputError
from halfphysics.live.clock import Clock, shortest
from halfphysics.live.edits import Editor
from halfphysics.live.follow import Follower
from halfphysics.live.incoming import IncomingPose, Outgoing, Stamp
from halfphysics.live.mailbox import Mailbox, Refusal
from halfphysics.live.scheduling import short_slices
from halfphysics.live.stance import stance
from halfphysics.motion.pose import Pose
from halfphysics.results.argument_checks import checked_settings
from halfphysics.simulation.simulator import Simulator

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.live.schema import Action
    from halfphysics.scene.scene import Scene
    from halfphysics.settings import Settings
    from halfphysics.simulation.frame import Frame

logger = logging.getLogger(__name__)

Listener = Callable[[Outgoing], None]
#: Is told whether an edit was done: None, or the reason why not.
Answer = Callable[[str | None], None]

#: Most edits between two steps; those that are more wait for the next.
_EDITS = 8
#: Most edits that wait.
_WAITING = 256
#: Distance between people who stand beside each other at the start [m].
_APART = 1.0


def _poses(start: Iterable[Pose] | None) -> list[Pose]:
    """The poses that are given; a pose alone is that of the first person."""
    if start is None:
        return []
    many = isinstance(start, Iterable) and not isinstance(start, str | bytes)
    poses: list[Pose] = list(start) if many else [cast("Pose", start)]
    for pose in poses:
        if not isinstance(pose, Pose):
            raise InputError(
                f"start: found {shown(pose)}, expected a list of one halfphysics.Pose a person "
                "(motion[0] gives one)"
            )
    return poses


def _upright(pose: Pose, pelvis: NDArray[np.float64]) -> Pose:
    """The same pose with axes of the identity: what is sent and recorded has no others."""
    moved = pose.translation + (pose.axes - np.eye(3)) @ pelvis
    return Pose(moved, pose.rotations, np.eye(3))


@dataclass(frozen=True)
class _Asked:
    action: Action
    source: str
    answer: Answer


@dataclass(frozen=True)
class _Gone:
    source: str


class Session:
    """People and a scene, stepped in real time.

    Args:
        scene: Statics and objects; None: an empty one.
        body: The body of the person, or a sequence, one each.
        start: The first people's first poses; the others stand beside each other. No more poses
            than people.
        settings: See `Settings`; `blocked` is "continue" whatever it says: who moves now does not
            wait for their body, and poses that wait would be late for ever after.
        fps: Steps per second.
        now: The server's clock [s].

    Attributes:
        now: The server's clock [s].
        simulator: The simulator; owned by the thread that steps.
        people: The people's names.
        mailbox: What arrived.
        clock: When steps are due.
        frames: Number of steps done.
        trouble: Error of the last step; "": none.
        edited: Number of changes of the scene's items.

    Raises:
        InputError: `start` has more poses than there are people, or something else.
        HalfPhysicsError: The simulation cannot start.
    """

    def __init__(
        self,
        scene: Scene | None = None,
        *,
        body: Body | Sequence[Body] | None = None,
        start: Iterable[Pose] | None = None,
        settings: Settings | None = None,
        fps: float = 90.0,
        now: Callable[[], float] = time.perf_counter,
    ) -> None:
        settings = replace(checked_settings(settings), blocked="continue")
        asked = _poses(start)
        self.simulator = Simulator(scene, body=body, settings=settings, fps=fps)
        world = self.simulator.world
        self.people = tuple(person.name for person in world.people)
        standing = [
            stance(person.body, world.made_of, y=_APART * i)
            for i, person in enumerate(world.people)
        ]
        if len(asked) > len(world.people):
            raise InputError(
                f"start: found {len(asked)} poses, expected at most {len(world.people)}, one a "
                "person. Give body= a list of bodies for more people, start=[motion[0]] for one"
            )
        given = [
            _upright(pose, person.body.rest_joints[0])
            for pose, person in zip(asked, world.people, strict=False)
        ]
        poses = [*given, *standing[len(given) :]]
        first = self.simulator.reset(poses)
        self.now = now
        self.mailbox = Mailbox(self.people, now, shortest(self.simulator.dt))
        self.clock = Clock(self.simulator.dt, now)
        self._followers = [
            Follower(pose, rest, person.body.rest_joints[0], self.simulator.dt)
            for pose, rest, person in zip(poses, standing, world.people, strict=True)
        ]
        self._editor = Editor(self.simulator, self.people)
        self._asked: queue.SimpleQueue[_Asked | _Gone] = queue.SimpleQueue()
        self._listeners: tuple[Listener, ...] = ()
        self._failed: list[Listener] = []
        self._stamps: dict[str, Stamp] = {}
        self._thread: threading.Thread | None = None
        self._running = False
        self.frames = self.edited = 0
        self.trouble = ""
        self.newest = self._outgoing(first)

    # -- from any thread -----------------------------------------------------------------

    def offer(self, pose: IncomingPose) -> Refusal | None:
        """Hand a pose over; returns the reason if it is not wanted."""
        return self.mailbox.offer(pose)

    def offer_all(self, poses: Sequence[IncomingPose]) -> list[Refusal | None]:
        """`offer` for poses of one moment, which are stepped together."""
        return self.mailbox.offer_all(poses)

    def deliver(self, pose: IncomingPose) -> None:
        """`Deliver` for receivers."""
        self.mailbox.offer(pose)

    def edit(self, action: Action, answer: Answer, source: str = "") -> None:
        """Ask for a change before the next step; `answer` is called by the thread that steps."""
        if self._asked.qsize() >= _WAITING:
            answer(f"edit: found {_WAITING} edits that wait, expected fewer. Ask again later")
        else:
            self._asked.put(_Asked(action, source, answer))

    def leave(self, source: str) -> None:
        """A source has gone: its people and what it dragged are free."""
        self.mailbox.release(source)
        self._asked.put(_Gone(source))  # after what it has asked for

    def listen(self, listener: Listener) -> None:
        """Call `listener` with every frame, in the thread that steps: it must not block."""
        self._listeners = (*self._listeners, listener)

    def unlisten(self, listener: Listener) -> None:
        """Undo `listen`."""
        self._listeners = tuple(other for other in self._listeners if other != listener)

    def start(self) -> None:
        """Step in a thread of its own until `stop`.

        Raises:
            InputError: It runs already.
        """
        if self._thread is not None:
            raise InputError("start: the session runs already; expected one that was stopped")
        self._running = True
        self._thread = threading.Thread(target=self._run, name="halfphysics-step", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop stepping; returns when the last step is done."""
        self._running = False
        self.mailbox.wake()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    @property
    def running(self) -> bool:
        """Whether steps are made."""
        return self._thread is not None and self._thread.is_alive()

    # -- by the thread that steps --------------------------------------------------------

    def _run(self) -> None:
        short_slices()
        while self._running:
            fresh = self.mailbox.fresh(self.clock.latest)
            expecting = not fresh and self.mailbox.expecting(self.clock.latest)
            wait = self.clock.wait(fresh, expecting)
            if wait > 0.0:
                self.mailbox.wait(wait)
                continue
            self.clock.begin(fresh)
            try:
                self.step()
            except HalfPhysicsError as error:
                self._fail(str(error))
            except Exception as error:  # a fault of ours: said once, the session goes on
                logger.exception("a step of the live session failed")
                self._fail(f"{type(error).__name__}: {error}")

    def _fail(self, trouble: str) -> None:
        if trouble != self.trouble:
            logger.warning("a step of the live session failed: %s", trouble)
        self.trouble = trouble

    def step(self) -> Outgoing:
        """Carry out edits, take the newest poses and make a frame.

        Raises:
            HalfPhysicsError: The simulation cannot go on from here.
        """
        self._obey()
        arrivals, now = self.mailbox.take(), self.now()
        targets = []
        for name, follower in zip(self.people, self._followers, strict=True):
            arrival = arrivals.get(name)
            # Of the pose that was taken: another may have come in since.
            age = self.mailbox.silence(name) if arrival is None else now - arrival.received
            # By the time of the physics, which is even: steps begin with poses, early or late.
            silence, interval = age + self.clock.early, self.mailbox.interval(name)
            targets.append(follower.advance(arrival, silence, interval))
        self._editor.pull()
        frame = self.simulator.step(targets)
        self.frames += 1
        done = self.now()
        for name, arrival in arrivals.items():
            self._stamps[name] = Stamp(arrival.pose.time, arrival.received, done)
        self.newest = self._outgoing(frame)
        self.trouble = ""
        for listener in self._listeners:
            self._tell(listener)
        return self.newest

    def _tell(self, listener: Listener) -> None:
        """Hand the newest frame over; a listener that fails harms neither steps nor others."""
        try:
            listener(self.newest)
        except Exception:
            if listener not in self._failed:
                self._failed.append(listener)
                logger.exception("a listener of the live session failed; said once")

    def _obey(self) -> None:
        done = 0
        while done < _EDITS:
            try:
                asked = self._asked.get_nowait()
            except queue.Empty:
                return
            if isinstance(asked, _Gone):
                self._editor.let_go(asked.source)
                continue
            done += 1
            try:
                self.edited += self._editor.do(asked.action, asked.source)
            except HalfPhysicsError as error:
                asked.answer(str(error))
            except Exception as error:  # a fault of ours: no edit may cost a step, or its answer
                logger.warning("an edit failed: %s: %s", type(error).__name__, error)
                asked.answer(f"edit: found {asked.action!r}, which cannot be simulated: {error}")
            else:
                asked.answer(None)

    def _outgoing(self, frame: Frame) -> Outgoing:
        followers = dict(zip(self.people, self._followers, strict=True))
        return Outgoing(
            frame=self.frames,
            time=self.frames * self.simulator.dt,
            clock=self.now(),
            poses=dict(zip(self.people, frame.poses, strict=True)),
            objects=frame.objects,
            joints=frame.joints,
            contacts=frame.contacts,
            names=self.simulator.names,
            dt=self.simulator.dt,
            clearance=frame.clearance,
            targets={name: follower.pose for name, follower in followers.items()},
            tracking={name: follower.tracking for name, follower in followers.items()},
            stamps=dict(self._stamps),
            simulated=frame,
        )
