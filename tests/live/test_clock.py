"""The physics clock: fixed steps whose phase follows the poses."""

from __future__ import annotations

from itertools import pairwise

import pytest

from halfphysics.live.clock import MOST, Clock, shortest

DT = 1.0 / 90.0


class Time:
    """A clock that is set."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def run(period, first, seconds, *, dt=DT, sends=True):
    """Times of steps, and how long poses waited, for poses that arrive at a period."""
    time, clock = Time(), None
    clock = Clock(dt, time)
    clock.begin(False)
    arrivals, waits, steps = [time.now + first], [], []
    while time.now < 100.0 + seconds:
        fresh = sends and arrivals[-1] <= time.now
        expecting = sends and not fresh and arrivals[-1] <= clock.latest
        wait = clock.wait(fresh, expecting)
        if wait > 0.0:
            until = time.now + wait
            time.now = min(until, arrivals[-1]) if sends and not fresh else until
            continue
        clock.begin(fresh)
        steps.append(time.now)
        if fresh:
            waits.append(time.now - arrivals[-1])
            while arrivals[-1] <= time.now:
                arrivals.append(arrivals[-1] + period)
    return steps, waits


def test_without_poses_steps_are_a_period_apart():
    steps, _ = run(DT, 0.0, 1.0, sends=False)
    assert [b - a for a, b in pairwise(steps)] == pytest.approx([DT] * 89)


@pytest.mark.parametrize("phase", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("skew", [1.0, 1.001, 0.999])
def test_a_pose_is_stepped_when_it_arrives(phase, skew):
    """Whatever the phase, and with a sender's clock that is wrong by a part in a thousand."""
    _, waits = run(DT * skew, phase * DT, 3.0)
    assert max(waits[60:]) < 1e-9


@pytest.mark.parametrize("period", [1.0, 1.25, 1.5, 2.0])
def test_steps_that_begin_with_poses_are_even_by_the_time_at_which_they_are_due(period):
    time = Time()
    clock, due, begun, even = Clock(DT, time), time.now, [], []
    while time.now < 102.0:
        fresh = due <= time.now
        if (wait := clock.wait(fresh, not fresh and due <= clock.latest)) > 0.0:
            time.now = min(time.now + wait, due) if not fresh else time.now + wait
            continue
        clock.begin(fresh)
        begun.append(time.now)
        even.append(time.now + clock.early)
        due += period * DT * fresh
    gaps = [b - a for a, b in pairwise(even[90:])]
    assert max(abs(gap - DT) for gap in gaps) <= MOST * DT + 1e-9
    assert max(abs(a - b) for a, b in zip(begun, even, strict=True)) <= 0.5 * DT + 1e-9


@pytest.mark.parametrize("phase", [0.05, 0.3, 0.7, 0.95])
def test_the_first_pose_gives_the_phase(phase):
    """No pose waits, the first ones neither."""
    _, waits = run(DT, phase * DT, 3.0)
    assert max(waits) < 1e-9


def test_who_pauses_on_purpose_hardly_speeds_the_physics_up():
    steps, _ = run(0.51, 0.01, 20.0)
    assert (steps[-1] - steps[0]) / (len(steps) - 1) > 0.97 * DT


@pytest.mark.parametrize("skew", [1.02, 0.98])
def test_the_rate_follows_the_sender_within_its_bound(skew):
    steps, waits = run(DT * skew, 0.3 * DT, 5.0)
    assert (steps[-1] - steps[100]) / (len(steps) - 101) == pytest.approx(DT * skew, rel=1e-3)
    assert max(waits[100:]) < 1e-9


def test_a_sender_twice_as_fast_does_not_speed_the_physics_up():
    steps, _ = run(DT / 2, 0.0, 5.0)
    assert (steps[-1] - steps[0]) / (len(steps) - 1) > 0.94 * DT


def test_missed_time_is_not_caught_up():
    time = Time()
    clock = Clock(DT, time)
    clock.begin(False)
    time.now += 10.5 * DT
    assert clock.wait(False, False) == 0.0
    clock.begin(False)
    assert clock.missed == 9
    assert clock.wait(False, False) == pytest.approx(DT)


def test_the_shortest_interval_is_one_that_the_clock_still_follows():
    skew = shortest(DT) / DT
    steps, waits = run(1.001 * shortest(DT), 0.3 * DT, 5.0)
    assert (steps[-1] - steps[100]) / (len(steps) - 101) == pytest.approx(DT * skew, rel=2e-3)
    assert max(waits[200:]) < 1e-9
