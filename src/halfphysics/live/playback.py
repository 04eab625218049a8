"""A clip played in real time by any sender: for tests, demos, and programs that only receive."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from halfphysics.base.validation import frame_rate, number
from halfphysics.live.client import LiveClient, connect
from halfphysics.live.incoming import Outgoing, Sender
from halfphysics.motion.motion import Motion
from halfphysics.simulation.core_rows import ContactRows


@dataclass(frozen=True)
class Played:
    """What was sent.

    Attributes:
        frames: Frames that were sent.
        late: Frames that were left out, since the next one was due.
        seconds: How long it took [s].
    """

    frames: int
    late: int
    seconds: float


def play(
    motion: Motion,
    senders: Sequence[Sender],
    *,
    person: str = "person0",
    fps: float | None = None,
    speed: float = 1.0,
    loop: bool = False,
    seconds: float | None = None,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Played:
    """Send a clip's frames when they are due; frames that are late are left out, but for the last.

    Args:
        motion: The clip, with `axes` of the identity (`Motion.rebased`).
        senders: Where to; each gets every frame.
        person: Name of the person in the frames.
        fps: Frames per second that are sent; None: the clip's.
        speed: How fast the clip goes: 2 is twice as fast.
        loop: Start again at its end.
        seconds: End after this time [s]; None: at the clip's end, or never.
        clock, sleep: Of the system.

    Raises:
        InputError: An impossible rate or speed.
    """
    rate = motion.fps if fps is None else frame_rate(fps)
    speed = number(speed, "speed", above=0.0, most=100.0)
    clip = motion.resample(rate / speed)
    count = np.inf if loop else len(clip)
    if seconds is not None:
        count = min(count, np.ceil(number(seconds, "seconds", above=0.0) * rate))
    begun, frame, sent = clock(), 0, 0
    while frame < count:
        wait = begun + frame / rate - clock()
        if wait > 0.0:
            sleep(wait)
        out = _frame(clip, frame, rate, person, clock() - begun)
        for sender in senders:
            sender.send(out)
        sent += 1
        due = max(frame + 1, int((clock() - begun) * rate))
        frame = int(count if frame == count - 1 else min(due, count - 1))
    return Played(sent, frame - sent, clock() - begun)


def _frame(clip: Motion, frame: int, rate: float, person: str, now: float) -> Outgoing:
    return Outgoing(
        frame=frame,
        time=frame / rate,
        clock=now,
        poses={person: clip[frame % len(clip)]},
        objects={},
        contacts=_NO_CONTACTS,
        names=(),
        dt=1.0 / rate,
        clearance=np.inf,
    )


_NONE, _NO_VECTORS = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
_NO_CONTACTS = ContactRows(
    person=_NONE,
    part=_NONE,
    subject=_NONE,
    other=_NONE,
    other_part=_NONE,
    position=_NO_VECTORS,
    normal=_NO_VECTORS,
    impulse=_NO_VECTORS,
)


class ClientSender:
    """A `Sender` to a live session: poses for it to correct, as any client sends them.

    Args:
        url: Its address, such as "ws://127.0.0.1:8765".
        person: Name of the person in the frames that come.
        to: Name of the person in the session; None: its first one.

    Raises:
        FileError: Nothing answers there, or it refuses.
    """

    def __init__(self, url: str, person: str, to: str | None = None) -> None:
        self._client: LiveClient = connect(url)
        self._person = person
        self._to = self._client.people[0] if to is None else to
        self._client.subscribe([], rate=0.0)

    def send(self, outgoing: Outgoing) -> None:
        """Send the person's pose.

        Raises:
            FileError: The session closed the connection.
            InputError: It refused the last pose.
        """
        pose = outgoing.poses.get(self._person)
        if pose is not None:
            self._client.send({self._to: pose}, time=outgoing.clock)
        try:
            self._client.receive(timeout=0.0)
        except TimeoutError:
            return

    def stop(self) -> None:
        """Close the connection."""
        self._client.close()
