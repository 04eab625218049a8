"""The target that follows the poses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from halfphysics.base import rotations as rot
from halfphysics.live.clock import Clock, shortest
from halfphysics.live.follow import (
    HOLD_AFTER,
    JOINT_SPEED,
    RELAX_AFTER,
    ROOT_SPEED,
    Follower,
)
from halfphysics.live.incoming import IncomingPose
from halfphysics.live.mailbox import Arrival, Mailbox
from halfphysics.live.stance import RELAXING
from halfphysics.motion.pose import Pose
from halfphysics.motion.skeleton import JOINT_INDEX

DT = 1.0 / 90.0
PELVIS = np.array([0.0, -0.35, 0.01])
ELBOW = JOINT_INDEX["left_elbow"]


def pose(x=0.0, elbow=0.0, axes=None):
    rotations = np.zeros((55, 3))
    rotations[0] = (np.pi / 2, 0, 0)
    rotations[ELBOW] = (0, elbow, 0)
    return Pose([x, 0, 1], rotations, np.eye(3) if axes is None else axes)


def arrival(pose, tracked=None, gap=DT, time=None):
    return Arrival(IncomingPose("ada", pose, time, tracked), 0.0, gap)


@pytest.fixture
def follower():
    rest = pose(elbow=-0.3)
    return Follower(pose(), rest, PELVIS, DT)


def live(follower, given=None, steps=30):
    """Somebody who is followed already."""
    for _ in range(steps):
        follower.advance(arrival(given or pose()), 0.0, DT)
    assert follower.tracking == "live"


def speeds(targets):
    """Largest speed of the root [m/s] and of a joint [rad/s] from target to target."""
    root = max(np.linalg.norm(b.translation - a.translation) for a, b in pairwise(targets))
    joint = max(rot.angles(a.rotations, b.rotations).max() for a, b in pairwise(targets))
    return root / DT, joint / DT


def test_motion_is_followed_exactly(follower):
    live(follower)
    for k in range(50):
        given = pose(x=0.05 * k, elbow=0.2 * np.sin(k))
        target = follower.advance(arrival(given), 0.0, DT)
        np.testing.assert_array_equal(target.translation, given.translation)
        np.testing.assert_array_equal(target.rotations, given.rotations)


@pytest.mark.parametrize("jump", [{"x": 3.0}, {"elbow": 2.5}, {"x": -1.0, "elbow": -1.5}])
def test_a_jump_is_reached_at_human_speed(follower, jump):
    live(follower)
    targets = [follower.pose]
    for _ in range(400):
        targets.append(follower.advance(arrival(pose(**jump)), 0.0, DT))
    root, joint = speeds(targets)
    # `ease` has its largest slope between two steps: the bound holds to a percent.
    assert root <= 1.01 * ROOT_SPEED
    assert joint <= 1.01 * JOINT_SPEED
    np.testing.assert_array_equal(targets[-1].translation, pose(**jump).translation)
    np.testing.assert_array_equal(targets[-1].rotations, pose(**jump).rotations)


def test_a_sender_s_clock_lets_nobody_jump(follower):
    """A clock of milliseconds, or any other: 30 m within a step stay a jump."""
    for k in range(30):
        follower.advance(arrival(pose(), time=1e300 * k), 0.0, DT)
    before = follower.pose
    jumped = follower.advance(arrival(pose(x=30.0), time=1e300 * 30), 0.0, DT)
    assert speeds([before, jumped])[0] < 1.01 * ROOT_SPEED
    late = follower.advance(arrival(pose(x=0.0), time=1e300 * 30 + 0.1), 0.0, DT)
    assert speeds([jumped, late])[0] < 1.01 * ROOT_SPEED


def test_another_sender_s_clock_lets_nobody_jump(follower):
    """Who takes over at once is elsewhere, and its clock is far ahead of the one before."""
    for k in range(30):
        follower.advance(arrival(pose(), time=k * DT), 0.0, DT)
    before = follower.pose
    other = IncomingPose("ada", pose(x=2.0), 1e6, source="other")
    after = follower.advance(Arrival(other, 0.0, DT), 0.0, DT)
    assert speeds([before, after])[0] < 1.01 * ROOT_SPEED


def test_the_first_pose_is_a_jump(follower):
    assert follower.tracking == "waiting"
    first = follower.advance(arrival(pose(x=2.0), gap=0.0), 0.0, 0.0)
    assert np.linalg.norm(first.translation - pose().translation) < ROOT_SPEED * DT


def test_motion_passes_through_while_a_jump_is_made_up(follower):
    """The elbow, which has not jumped, is where it is sent from the first step on."""
    live(follower)
    for k in range(20):
        target = follower.advance(arrival(pose(x=3.0, elbow=0.02 * k)), 0.0, DT)
        assert target.rotations[ELBOW, 1] == pytest.approx(0.02 * k, abs=1e-12)


def test_a_glitch_of_one_pose_moves_nobody_far(follower):
    live(follower)
    follower.advance(arrival(pose(x=5.0)), 0.0, DT)
    targets = [follower.advance(arrival(pose()), 0.0, DT) for _ in range(50)]
    assert max(abs(t.translation[0]) for t in targets) < 0.01


def test_rotations_beyond_half_a_turn_are_no_jump(follower):
    given = pose()
    rotations = given.rotations.copy()
    rotations[0] = (0, 0, 0.999 * np.pi)
    live(follower, Pose(given.translation, rotations), 300)
    rotations = rotations.copy()
    rotations[0] = (0, 0, -0.999 * np.pi)
    target = follower.advance(arrival(Pose(given.translation, rotations)), 0.0, DT)
    np.testing.assert_array_equal(target.rotations[0], rotations[0])


def test_who_is_lost_is_held_then_relaxes_then_comes_back(follower):
    given = pose(x=1.0, elbow=0.8)
    live(follower, given, 300)
    for silence in np.arange(0.0, RELAX_AFTER, DT):
        target = follower.advance(None, silence, DT)
        np.testing.assert_array_equal(target.rotations, given.rotations)
        assert follower.tracking == ("held" if silence > HOLD_AFTER else "live")
    targets = [follower.pose]
    for k in range(300):
        targets.append(follower.advance(None, RELAX_AFTER + (k + 1) * DT, DT))
    assert follower.tracking == "relaxed"
    assert targets[-1].rotations[ELBOW, 1] == pytest.approx(-0.3)
    np.testing.assert_array_equal(targets[-1].translation, given.translation)
    np.testing.assert_array_equal(targets[-1].rotations[~RELAXING], given.rotations[~RELAXING])
    for _ in range(300):
        targets.append(follower.advance(arrival(given, gap=5.0), 0.0, DT))
    assert follower.tracking == "live"
    assert speeds(targets)[1] <= 1.01 * JOINT_SPEED
    np.testing.assert_array_equal(targets[-1].rotations, given.rotations)


def test_joints_that_are_not_tracked_are_kept_then_relax(follower):
    live(follower, pose(elbow=0.8), 300)
    tracked = np.ones(55, dtype=bool)
    tracked[ELBOW] = False
    held = [
        follower.advance(arrival(pose(elbow=0.0), tracked), 0.0, DT)
        for _ in range(int(0.9 * RELAX_AFTER / DT))
    ]
    assert {target.rotations[ELBOW, 1] for target in held} == {0.8}
    for _ in range(int(RELAX_AFTER / DT)):
        target = follower.advance(arrival(pose(elbow=0.0), tracked), 0.0, DT)
    assert target.rotations[ELBOW, 1] == pytest.approx(-0.3)


def test_slow_senders_are_interpolated(follower):
    """A pose of 30 Hz is reached in three steps of 90 Hz, at the speed of the motion."""
    live(follower)
    for _ in range(10):  # the usual gap is 3 steps
        follower.advance(arrival(pose(), gap=3 * DT), 0.0, 3 * DT)
    follower.advance(arrival(pose(x=0.09), gap=3 * DT), 0.0, 3 * DT)
    xs = [follower.pose.translation[0]]
    xs += [follower.advance(None, DT, 3 * DT).translation[0] for _ in range(3)]
    assert xs == pytest.approx([0.03, 0.06, 0.09, 0.09])


#: Largest change of speed of somebody who moves evenly, whose poses move the phase of the clock by
#: up to 5 % of a step, twice before a pose is due; and by how much the clock follows the sender's.
EVEN, MORE = 0.25, 0.05


def walked(rate, speed=1.0, seconds=4.0, jitter=0.0, lost=0):
    """Targets of somebody who is sent at even speed, by the clock and the mailbox of a session.

    Poses arrive up to `jitter` [s] late; of `lost` one never does.
    """
    time = [0.0]
    clock, box = Clock(DT, lambda: time[0]), Mailbox(["ada"], lambda: time[0], shortest(DT))
    follower = Follower(pose(), pose(), PELVIS, DT)
    taken = [k / rate for k in range(int(seconds * rate)) if not lost or k % lost]
    late = np.random.default_rng(0).uniform(0.0, jitter, len(taken))
    due = np.sort(taken + late).tolist()
    sent, steps = 0, []
    while time[0] < due[-1]:
        while due[sent] <= time[0]:
            box.offer(IncomingPose("ada", pose(x=speed * taken[sent])))
            sent += 1
        fresh = box.fresh(clock.latest)
        wait = clock.wait(fresh, not fresh and box.expecting(clock.latest))
        if wait > 0.0:
            time[0] = min(time[0] + wait, due[sent])
            continue
        clock.begin(fresh)
        silence = box.silence("ada") + clock.early
        target = follower.advance(box.take().get("ada"), silence, box.interval("ada"))
        steps.append((time[0], target.translation[0]))
    return np.array(steps[len(steps) // 2 :])


@pytest.mark.parametrize("rate", [11, 24, 30, 45, 50, 60, 66, 72, 80, 82, 84, 90])
def test_whoever_moves_evenly_is_followed_evenly(rate):
    """At any rate up to that of the physics, and never later than an interval and a step."""
    times, places = walked(rate).T
    speeds = np.diff(places) / DT
    assert np.abs(speeds - 1.0).max() < EVEN
    assert speeds.mean() == pytest.approx(1.0, abs=MORE)
    assert (times - places).max() < 1.0 / rate + DT


@pytest.mark.parametrize("rate", [96, 100, 120, 144, 175, 180, 200, 240, 500])
def test_faster_senders_are_followed_evenly(rate):
    """They go as far in every step, however old the newest pose is, and an interval late."""
    times, places = walked(rate).T
    assert np.diff(places) / DT == pytest.approx(1.0, abs=1e-6)
    assert times - places == pytest.approx(1.0 / rate, abs=1e-6)


@pytest.mark.parametrize("rate", [100, 120, 144, 240])
def test_of_faster_senders_jitter_is_little_in_the_target(rate):
    """A pose that is late by a part of a step changes the speed by no more than that part."""
    _, places = walked(rate, jitter=0.2 * DT).T
    assert np.abs(np.diff(places) / DT - 1.0).max() < 0.2


@pytest.mark.parametrize("rate", [30, 45, 90])
def test_jitter_of_the_network_is_not_in_the_target(rate):
    """Where the interval is a whole number of steps, the speed is that of the poses."""
    _, places = walked(rate, jitter=0.004).T
    assert np.diff(places) / DT == pytest.approx(1.0, abs=1e-9)


def test_a_lost_pose_makes_the_ones_after_it_no_later():
    """At the sender's own rate every pose that arrives is reached in the step that takes it."""
    times, places = walked(90, lost=10).T
    late = times - places > 1e-6
    assert late.mean() < 1.5 / 10
    assert not (late[:-1] & late[1:]).any()


def stepped(rate, steps, seconds, tracked=None, speed=0.0, elbow=0.0):
    """Times and targets of so many steps a second, however fast poses come, without a clock's."""
    time = [0.0]
    box = Mailbox(["ada"], lambda: time[0], shortest(DT))
    follower = Follower(pose(elbow=elbow), pose(elbow=-0.3), PELVIS, DT)
    sent, found = 0, []
    for step in range(1, int(seconds * steps)):
        while sent / rate <= step / steps:
            time[0] = sent / rate
            known = tracked if sent > rate / 2 else None
            box.offer(IncomingPose("ada", pose(x=speed * time[0], elbow=elbow), None, known))
            sent += 1
        time[0] = step / steps
        silence, interval = box.silence("ada"), box.interval("ada")
        target = follower.advance(box.take().get("ada"), silence, interval)
        found.append((time[0], target))
    return found


def test_on_a_slow_machine_a_walk_is_no_jump():
    """Most poses are replaced before a step: the next one is compared over all of that time."""
    for time, target in stepped(90, steps=15, seconds=4.0, speed=2.0)[20:]:
        assert target.translation[0] == pytest.approx(2.0 * time, abs=0.1)


@pytest.mark.parametrize("rate", [90, 120, 500])
def test_joints_relax_after_as_long_where_poses_are_replaced(rate):
    tracked = np.ones(55, dtype=bool)
    tracked[ELBOW] = False
    found = stepped(rate, steps=90, seconds=5.0, tracked=tracked, elbow=0.8)
    lost = [time for time, target in found if abs(target.rotations[ELBOW, 1] - 0.8) > 1e-3]
    assert lost[0] - 0.5 == pytest.approx(RELAX_AFTER, abs=0.1)


@pytest.mark.parametrize("time", [None, 50.0])
def test_after_a_stall_of_the_physics_nobody_leaps(follower, time):
    """Who ran on meanwhile is reached at human speed, whatever the time that passed."""
    live(follower)
    given = arrival(pose(x=8.0), gap=2.0, time=time)
    before = follower.pose.translation[0]
    assert follower.advance(given, 0.0, DT).translation[0] - before < 2.6 * DT


def test_other_axes_are_turned_into_the_start_s(follower):
    live(follower)
    axes = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    given = pose(axes=axes)
    for _ in range(300):
        target = follower.advance(arrival(given), 0.0, DT)
    pelvis = given.translation + axes @ PELVIS
    np.testing.assert_allclose(target.translation + target.axes @ PELVIS, pelvis, atol=1e-12)


def test_put(follower):
    follower.put(pose(x=4.0))
    assert follower.pose.translation[0] == 4.0


@pytest.mark.parametrize("every", [1, 3, 6])
def test_joints_relax_after_as_long_whatever_the_sender_s_rate(follower, every):
    live(follower, pose(elbow=0.8), 300)
    tracked = np.ones(55, dtype=bool)
    tracked[ELBOW] = False
    steps = 0
    while steps < 2 * RELAX_AFTER / DT:
        steps += 1
        came = steps % every == 0
        lost = arrival(pose(elbow=0.0), tracked, gap=every * DT) if came else None
        target = follower.advance(lost, 0.0, every * DT)
        if abs(target.rotations[ELBOW, 1] - 0.8) > 1e-3:
            break
    # It begins slowly, and with the next pose.
    assert steps * DT == pytest.approx(RELAX_AFTER, abs=2 * every * DT + 0.1)
