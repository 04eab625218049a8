"""A client that moves two people through the demo's scene, and measures how long that takes."""

from __future__ import annotations

import gc
import sys
import time
from dataclasses import dataclass, field

import numpy as np

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.live.client import connect
from halfphysics.live.interpreter import SWITCH
from halfphysics.live.scheduling import short_slices

#: The second person walks beside the first, so that both meet walls and the table [m].
BESIDE = np.array([0.0, 0.8, 0.0])


def two_people(fps: float) -> list[dict[str, hp.Pose]]:
    """The demo's walk, there and back, for two people."""
    motion = scenarios.load("doorway").motions[0].resample(fps)
    there = [
        {
            "person0": pose,
            "person1": hp.Pose(pose.translation + BESIDE, pose.rotations),
        }
        for pose in (motion[i] for i in range(len(motion)))
    ]
    return [*there, *there[-2:0:-1]]


@dataclass
class Driven:
    """What came of driving.

    Attributes:
        seconds: Of every pose that came back, from `send` to its corrected pose (n,) [s].
        sent: Poses sent.
        lost: Poses whose frame did not come before the next pose was due.
        contacts: Contacts of all frames.
        late: Poses that were sent more than a millisecond after their time.
    """

    sent: int = 0
    lost: int = 0
    contacts: int = 0
    late: int = 0
    seconds: list[float] = field(default_factory=list)

    def figures(self) -> str:
        """The figures in one line."""
        ms = 1000.0 * np.array(self.seconds)
        p50, p99, p999 = np.percentile(ms, [50, 99, 99.9])
        return (
            f"latency p50 {p50:.2f} ms, p99 {p99:.2f} ms, p99.9 {p999:.2f} ms, worst "
            f"{ms.max():.2f} ms, jitter (deviation) {ms.std():.2f} ms; {self.sent} poses, "
            f"{self.lost} not back before the next ({self.late} sent late); "
            f"{self.contacts / max(len(ms), 1):.1f} contacts a frame"
        )


def drive(url: str, seconds: float, fps: float = 90.0) -> Driven:
    """Send poses of two people at a rate and wait for each to come back."""
    poses, driven = two_people(fps), Driven()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH)
    short_slices()  # as the server's threads: a client in a hurry does so too
    gc.collect()
    gc.freeze()
    try:
        with connect(url) as live:
            _drive(live, poses, driven, seconds, 1.0 / fps)
    finally:
        gc.unfreeze()
        sys.setswitchinterval(interval)
    return driven


def _drive(live, poses, driven: Driven, seconds: float, dt: float) -> None:
    begun = due = time.perf_counter()
    for k in range(10**9):
        now = time.perf_counter()
        if now - begun > seconds:
            return
        if due > now:
            time.sleep(due - now)
        sent = time.perf_counter()
        driven.late += sent - due > 1e-3
        live.send(poses[k % len(poses)], time=sent)
        driven.sent += 1
        due = max(due + dt, sent)
        if (frame := _answer(live, sent, due)) is None:
            driven.lost += 1
            continue
        driven.seconds.append(time.perf_counter() - sent)
        driven.contacts += len(frame.contacts)


def _answer(live, sent: float, until: float):
    """The frame that stepped the pose of this time; None: not before the next is due."""
    while (left := until - time.perf_counter()) > 0.0:
        try:
            frame = live.receive(left)
        except TimeoutError:
            return None
        if all(name in frame.stamps for name in live.people) and all(
            stamp.sent == sent for stamp in frame.stamps.values()
        ):
            return frame
    return None
