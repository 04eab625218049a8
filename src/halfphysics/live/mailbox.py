"""The newest pose of every person: what arrives from any thread, until the next step takes it.

There is no queue: a pose that was not stepped yet is replaced by the next one, and counted.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from halfphysics.live.incoming import IncomingPose
from halfphysics.live.interval import Interval
from halfphysics.live.wakeup import Wakeup

#: A pose whose time is farther back than this belongs to a sender that started again [s].
_RESTART = 1.0
#: A source that was silent for so long does not own its person any more [s].
SILENT = 1.0
#: A larger gap between two poses is a pause, which says nothing of the sender's rate [s].
_PAUSE = 0.5

Refusal = Literal["unknown", "busy", "late"]


@dataclass(frozen=True)
class Arrival:
    """A pose that waits for the next step.

    Attributes:
        pose: The pose.
        received: When it arrived, by the server's clock [s].
        gap: Time since the one that a step took before it arrived [s], whatever was replaced in
            between; 0 for the first.
    """

    pose: IncomingPose
    received: float
    gap: float


@dataclass
class Counts:
    """What became of poses: taken by a step, replaced before one, refused."""

    stepped: int = 0
    replaced: int = 0
    late: int = 0
    unknown: int = 0
    busy: int = 0

    @property
    def dropped(self) -> int:
        """Poses that no step has seen."""
        return self.replaced + self.late + self.unknown + self.busy


class _Slot:
    """One person's place in the mailbox."""

    def __init__(self) -> None:
        self.arrival: Arrival | None = None
        self.source: str | None = None
        self.time: float | None = None
        self.received = -float("inf")
        self.interval = Interval()


class Mailbox:
    """The newest poses of people.

    Args:
        people: Names of the people that there are.
        now: The server's clock [s].
        least: Poses that come more often than this are not waited for [s]: there is always one.

    Attributes:
        counts: What became of the poses.
    """

    def __init__(
        self,
        people: Sequence[str],
        now: Callable[[], float] = time.perf_counter,
        least: float = 0.0,
    ) -> None:
        self._now, self._least = now, least
        self._slots = {name: _Slot() for name in people}
        self._changed = threading.Lock()
        self._wakeup = Wakeup()
        self.counts = Counts()

    # -- from any thread -----------------------------------------------------------------

    def deliver(self, pose: IncomingPose) -> None:
        """`offer` for receivers that cannot tell their sender."""
        self.offer(pose)

    def offer(self, pose: IncomingPose) -> Refusal | None:
        """Put a pose in, unless there is a reason against it, which is returned."""
        return self.offer_all([pose])[0]

    def offer_all(self, poses: Sequence[IncomingPose]) -> list[Refusal | None]:
        """`offer` for poses of one moment: the step sees all of them or none."""
        with self._changed:
            refused = [self._refusal(pose) for pose in poses]
        if None in refused:
            self._wakeup.wake()
        return refused

    def release(self, source: str) -> None:
        """A source has gone: others may take over its people at once."""
        with self._changed:
            for slot in self._slots.values():
                if slot.source == source:
                    slot.source = slot.time = None

    def wake(self) -> None:
        """Let `wait` return, since there is something else to do."""
        self._wakeup.wake()

    # -- by the thread that steps --------------------------------------------------------

    def wait(self, seconds: float) -> None:
        """Wait until a pose arrives or somebody wakes us, at most so long."""
        self._wakeup.wait(seconds)

    def take(self) -> dict[str, Arrival]:
        """Name of a person -> its newest pose, of those that have a new one."""
        with self._changed:
            taken = {}
            for name, slot in self._slots.items():
                if slot.arrival is not None:
                    taken[name], slot.arrival = slot.arrival, None
            self.counts.stepped += len(taken)
            return taken

    def fresh(self, until: float) -> bool:
        """Whether there is a new pose, and none is expected before `until` (server's clock), of
        senders that are waited for."""
        found = False
        with self._changed:
            for slot in filter(self._awaited, self._slots.values()):
                if slot.arrival is not None:
                    found = True
                elif self._expected(slot) <= until:
                    return False
        return found

    def expecting(self, until: float) -> bool:
        """Whether a pose is expected before `until` (server's clock)."""
        with self._changed:
            return any(
                slot.arrival is None and self._expected(slot) <= until
                for slot in filter(self._awaited, self._slots.values())
            )

    def silence(self, person: str) -> float:
        """Time since the person's last pose arrived [s]; inf: none did."""
        return self._now() - self._slots[person].received

    def interval(self, person: str) -> float:
        """Usual time between two poses of the person [s]; 0: unknown."""
        return self._slots[person].interval.seconds

    def _awaited(self, slot: _Slot) -> bool:
        return not 0.0 < slot.interval.seconds < self._least

    def _expected(self, slot: _Slot) -> float:
        """When the next pose arrives if the sender goes on; inf: it has stopped."""
        interval = slot.interval.seconds
        if interval == 0.0 or self._now() - slot.received > 3.0 * interval:
            return float("inf")
        return slot.received + 0.8 * interval

    def _refusal(self, pose: IncomingPose) -> Refusal | None:
        slot = self._slots.get(pose.person)
        if slot is None:
            self.counts.unknown += 1
            return "unknown"
        now = self._now()
        other = slot.source is not None and pose.source != slot.source
        if other and now - slot.received < SILENT:
            self.counts.busy += 1
            return "busy"
        if not other and _is_late(pose.time, slot.time):
            self.counts.late += 1
            return "late"
        self._put(slot, pose, now)
        return None

    def _put(self, slot: _Slot, pose: IncomingPose, now: float) -> None:
        gap = now - slot.received
        if slot.source != pose.source or gap > _PAUSE:
            slot.interval.clear()
        else:
            slot.interval.add(gap)
        since = gap if gap < 1e9 else 0.0
        if slot.arrival is not None:
            self.counts.replaced += 1
            since += slot.arrival.gap
        slot.arrival = Arrival(pose, now, since)
        slot.source, slot.time, slot.received = pose.source, pose.time, now


def _is_late(time: float | None, newest: float | None) -> bool:
    return time is not None and newest is not None and newest - _RESTART < time < newest
