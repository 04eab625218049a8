"""What the script in the page of `play` is told, and what it asks for (player/main.js)."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.viewer import session as do
from halfphysics.viewer.camera import PRESETS
from halfphysics.viewer.coloring import RAMP
from halfphysics.viewer.contacts import KINDS, PERSON
from halfphysics.viewer.live_contacts import LiveContacts
from halfphysics.viewer.marks import LEAST, Mark, Row, kind_label
from halfphysics.viewer.remote import Remote
from halfphysics.viewer.skin_forces import live_points

if TYPE_CHECKING:
    from halfphysics.viewer.playground import Playground

Array = NDArray[np.float64]

# Interval between updates of the marks [s].
_MARKS = 0.5


class LiveMarks:
    """The marks of a simulation so far: of each kind of contact, the largest force by frame.

    Args:
        frames: Number of frames of the motion.
        fps: Frames per second.
        people: Number of people; one person alone touches no other.
    """

    def __init__(self, frames: int, fps: float, people: int = 1) -> None:
        self._alone = people == 1
        self._force = np.zeros((len(KINDS), frames))
        self._fps = fps

    def add(self, frame: int, kind: NDArray[np.int64], force: Array) -> None:
        """Take the contacts of a frame: their kinds (n,) and sizes of force (n,) [N].

        A frame that is made again, in the next loop, replaces what it had.
        """
        self._force[:, frame] = 0.0
        np.maximum.at(self._force[:, frame], kind, force)

    def rows(self) -> list[Row]:
        """A row for each kind, empty ones too: a bar that grows would move the scene."""
        found = []
        for kind, force in enumerate(self._force):
            if kind == PERSON and self._alone:
                continue
            frames = np.flatnonzero(force >= LEAST)
            runs = np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1) if len(frames) else []
            marks = tuple(
                Mark(
                    max(int(run[0]) - 1, 0) / self._fps,
                    int(run[-1]) / self._fps,
                    f"up to {force[run].max():.0f} N",
                )
                for run in runs
            )
            found.append(Row(kind_label(kind), KINDS[kind].color, marks))
        return found


class LiveWire:
    """Connects the script in the page with a playground, whose thread calls all but `obey`."""

    def __init__(self, playground: Playground) -> None:
        self._playground = playground
        self._marks = LiveMarks(1, 1.0)
        self._marked = -math.inf
        self.remote = Remote(playground.server.gui, self.obey)

    def new_story(self) -> None:
        """Tell of the people of a new simulation; its marks begin anew."""
        playground = self._playground
        session = playground.session
        people = [figure.name for figure in playground.stage.people]
        self._marks = LiveMarks(session.frames, session.fps, len(people))
        self.remote.tell(
            data={
                "title": f"{session.choice} | halfphysics play",
                "ramp": [list(color) for color in RAMP],
                "people": people,
                "of": [],
                "skin": None,
                "compare": [],
                "dropText": "A running simulation takes no files: halfphysics play FILE",
            },
            marks=[row.document() for row in self._marks.rows()],
        )
        self.remote.tell_now(points=[[] for _ in people])

    def frame(self) -> None:
        """Tell of the contacts of the frame that is shown."""
        session = self._playground.session
        contacts = session.frame.contacts
        live = LiveContacts(session).at(0)
        force = np.linalg.norm(live.force, axis=1)
        self._marks.add(session.index, live.kind, force)
        points = []
        for k, (body, pose) in enumerate(
            zip(session.simulator.bodies, session.frame.poses, strict=True)
        ):
            mine = np.asarray(contacts.person) == k
            frames = body.joint_frames(pose)
            points.append(
                live_points(body, contacts.part[mine], live.position[mine], force[mine], *frames)
            )
        self.remote.tell_now(points=points)

    def refresh(self) -> None:
        """Tell of the time, and now and then of the marks."""
        session = self._playground.session
        clock = {
            "live": True,
            "time": round(session.index / session.fps, 4),
            "playing": session.playing,
            "speed": session.speed,
            "duration": round((session.frames - 1) / session.fps, 4),
            "fps": session.fps,
        }
        self.remote.tell(clock=clock)
        now = time.monotonic()
        if now - self._marked > _MARKS:
            self._marked = now
            self.remote.tell(marks=[row.document() for row in self._marks.rows()])

    def obey(self, name: str, value: Any, client: Any) -> None:
        """Execute a command of a browser's script; a value that does not fit is ignored."""
        playground = self._playground
        post, cameras = playground.post, playground.cameras
        if name == "toggle":
            post(do.Play(not playground.session.playing))
        elif name == "step":
            post(do.Step())
        elif name == "seek" and value == 0:
            post(do.Restart())
        elif name == "seek":
            self.remote.say("A live simulation cannot go to another time; Home starts it again.")
        elif name == "speed" and isinstance(value, int | float):
            post(do.Change("speed", min(max(float(value), do.SPEEDS[0]), do.SPEEDS[1])))
        elif name == "preset" and value in PRESETS:
            playground.do(lambda: cameras.preset(client, value))
        elif name == "home":
            playground.do(lambda: cameras.home(client))
        elif name == "follow":
            playground.do(self.follow)

    def follow(self) -> None:
        """Let the cameras follow, or stay."""
        panel = self._playground.panel
        panel.follow.value = not panel.follow.value
        panel.follow_now()
        self.remote.say("The camera follows." if panel.following else "The camera stays.")
