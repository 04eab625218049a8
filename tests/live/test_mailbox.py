"""The newest pose of every person."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from halfphysics.live.incoming import IncomingPose
from halfphysics.live.mailbox import SILENT, Mailbox
from halfphysics.motion.pose import Pose


class Time:
    def __init__(self):
        self.now = 10.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Time()


@pytest.fixture
def box(clock):
    return Mailbox(("ada", "ben"), clock)


def pose(person="ada", time=None, source="a", x=0.0):
    return IncomingPose(person, Pose([x, 0, 0], np.zeros((55, 3))), time, source=source)


def test_the_newest_wins_and_the_others_are_counted(box):
    for x in (1.0, 2.0, 3.0):
        box.deliver(pose(x=x))
    taken = box.take()
    assert list(taken) == ["ada"]
    assert taken["ada"].pose.pose.translation[0] == 3.0
    assert box.take() == {}
    assert (box.counts.stepped, box.counts.replaced, box.counts.dropped) == (1, 2, 2)


def test_the_gap_is_from_the_pose_that_was_taken(box, clock):
    """Steps compare with that one, not with one that was replaced."""
    box.offer(pose())
    clock.now += 0.02
    box.offer(pose())
    assert box.take()["ada"].gap == pytest.approx(0.02)  # nobody had any before the first
    for _ in range(3):
        clock.now += 0.02
        box.offer(pose())
    assert box.take()["ada"].gap == pytest.approx(0.06)
    assert box.interval("ada") == pytest.approx(0.02)  # of all that arrived
    clock.now += 0.02
    box.offer(pose())
    assert box.take()["ada"].gap == pytest.approx(0.02)


def test_late_ones_are_dropped(box):
    assert box.offer(pose(time=5.0)) is None
    assert box.offer(pose(time=4.9)) == "late"
    assert box.offer(pose(time=5.0)) is None  # a clock that stands still is none
    assert box.counts.late == 1


def test_a_sender_that_started_again_is_heard(box):
    assert box.offer(pose(time=500.0)) is None
    assert box.offer(pose(time=0.1)) is None
    assert box.offer(pose(time=0.2)) is None


def test_nobody_by_that_name(box):
    assert box.offer(pose("eve")) == "unknown"
    assert box.counts.unknown == 1


def test_a_person_follows_one_source_at_a_time(box, clock):
    assert box.offer(pose(source="a", time=9.0)) is None
    assert box.offer(pose(source="b", time=1.0)) == "busy"
    clock.now += SILENT + 0.1
    assert box.offer(pose(source="b", time=1.0)) is None
    assert box.offer(pose(source="a", time=9.1)) == "busy"
    box.release("b")
    assert box.offer(pose(source="a", time=0.0)) is None


def test_a_step_waits_for_all_who_send(box, clock):
    for _ in range(20):
        for name in ("ada", "ben"):
            box.offer(pose(name))
        box.take()
        clock.now += 0.01
    assert box.interval("ada") == pytest.approx(0.01)
    assert box.expecting(clock.now + 0.005)
    assert not box.fresh(clock.now + 0.005)
    box.offer(pose("ada"))
    assert not box.fresh(clock.now + 0.005)  # ben's is still to come
    box.offer(pose("ben"))
    assert box.fresh(clock.now + 0.005)


def test_nobody_waits_for_who_has_stopped(box, clock):
    for _ in range(5):
        for name in ("ada", "ben"):
            box.offer(pose(name))
        clock.now += 0.01
    clock.now += 0.05
    box.take()
    box.offer(pose("ada"))
    assert box.fresh(clock.now + 0.01)


def test_nobody_waits_for_who_sends_faster_than_steps(clock):
    box = Mailbox(("ada", "ben"), clock, least=0.009)
    for k in range(40):
        box.offer(pose("ada"))
        if k % 2:
            box.offer(pose("ben"))
        clock.now += 0.005
    box.take()
    box.offer(pose("ada"))
    assert not box.fresh(clock.now)  # the clock does not follow her
    box.offer(pose("ben"))
    assert box.fresh(clock.now + 0.005)  # ada's next one is not waited for
    assert set(box.take()) == {"ada", "ben"}
    clock.now += 0.009
    assert box.expecting(clock.now)
    box.offer(pose("ben"))
    assert not box.expecting(clock.now)


def test_silence(box, clock):
    assert box.silence("ada") == float("inf")
    box.offer(pose())
    clock.now += 0.5
    assert box.silence("ada") == pytest.approx(0.5)


def test_waiting_ends_with_a_pose():
    box = Mailbox(("ada",))
    threading.Timer(0.05, box.deliver, [pose()]).start()
    begun = time.perf_counter()
    box.wait(20.0)
    assert time.perf_counter() - begun < 10.0
    assert box.take()
    box.deliver(pose())  # before anybody waits
    box.wait(20.0)
    assert time.perf_counter() - begun < 10.0


def test_poses_of_one_moment_wake_the_step_once(box, monkeypatch):
    """A step that begins sees all of them: it is woken when the last one is in."""
    seen = []
    monkeypatch.setattr(box._wakeup, "wake", lambda: seen.append(sorted(box.take())))
    assert box.offer_all([pose("ada"), pose("eve"), pose("ben")]) == [None, "unknown", None]
    assert seen == [["ada", "ben"]]
    assert box.offer_all([pose("eve")]) == ["unknown"]
    assert len(seen) == 1
