"""A session without a server: poses in, frames out."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.base.axes import AXES
from halfphysics.errors import InputError
from halfphysics.live import schema
from halfphysics.live.incoming import IncomingPose
from halfphysics.live.session import Session


def moved(session, person, by, **changes):
    """A person's present target, moved by (3,) [m]."""
    pose = session.newest.targets[person]
    return IncomingPose(person, hp.Pose(pose.translation + by, pose.rotations), **changes)


def test_people_stand_and_nothing_happens(session):
    first = session.newest
    for _ in range(30):
        frame = session.step()
    assert frame.frame == 30
    assert frame.time == pytest.approx(30 / 90)
    for name in ("person0", "person1"):
        off = frame.poses[name].translation - first.poses[name].translation
        assert np.abs(off).max() < 2e-3
        assert frame.tracking[name] == "waiting"
    assert frame.stamps == {}


def test_free_motion_comes_back_as_it_was_sent(session):
    """Within the exactness of the drive: nothing is in the way of a raised arm."""
    for k in range(60):
        pose = session.newest.targets["person0"]
        rotations = pose.rotations.copy()
        rotations[16] = (0.0, 0.0, -1.25 + 0.01 * k)
        session.deliver(IncomingPose("person0", hp.Pose(pose.translation, rotations), k / 90))
        frame = session.step()
    sent = frame.targets["person0"].rotations[16]
    assert np.abs(frame.poses["person0"].rotations[16] - sent).max() < 1e-3
    assert frame.stamps["person0"].sent == 59 / 90
    assert frame.stamps["person0"].received <= frame.stamps["person0"].stepped <= frame.clock
    assert "person1" not in frame.stamps


def test_a_wall_stops(scene):
    """Sent 4 m through the wall at 2 m/s, the body stays before it and the wall is felt."""
    felt, now = 0.0, 0.0
    session = Session(scene, body=[hp.Body.default()] * 2, now=lambda: now)
    for k in range(180):
        now = k / 90.0  # a busy machine's clock would show a sender that falls behind
        session.deliver(moved(session, "person0", (2.0 / 90.0, 0, 0)))
        frame = session.step()
        wall = frame.names.index("wall")
        hit = (frame.contacts.other == wall) & (frame.contacts.person == 0)
        felt = max(felt, np.abs(frame.contacts.impulse[hit]).sum())
    body = session.simulator.bodies[0]
    assert body.joints(frame.poses["person0"])[:, 0].max() < 1.9
    assert body.joints(frame.targets["person0"])[0, 0] > 3.0
    assert felt > 0.1
    session.stop()


def test_the_same_poses_give_the_same_bits(scene):
    def run():
        clock = iter(range(10**9))
        session = Session(scene, now=lambda: next(clock) * 1e-4)
        for k in range(40):
            session.deliver(moved(session, "person", (0.01, 0, 0), time=k / 90))
            session.step()
        return session.simulator.get_state().numbers

    assert run() == run()


def test_a_pose_is_as_old_as_it_is_whatever_comes_in_meanwhile(scene, monkeypatch):
    """Another pose, just after the one of this step was taken, does not make that one new."""
    now, ages = 10.0, []
    session = Session(scene, now=lambda: now)
    take, advance = session.mailbox.take, session._followers[0].advance

    def taken():
        found = take()
        session.deliver(moved(session, "person", (0.0, 0.0, 0.0)))
        return found

    def advanced(arrival, silence, interval):
        ages.append(silence)
        return advance(arrival, silence, interval)

    monkeypatch.setattr(session.mailbox, "take", taken)
    monkeypatch.setattr(session._followers[0], "advance", advanced)
    session.deliver(moved(session, "person", (0.0, 0.0, 0.0)))
    now += 0.004
    session.step()
    assert ages == pytest.approx([0.004])


def test_a_running_session_steps_in_real_time(session):
    frames, enough = [], threading.Event()

    def listen(frame):
        frames.append(frame)
        if len(frames) == 20:
            enough.set()

    session.listen(listen)
    session.start()
    assert session.running
    with pytest.raises(InputError, match="runs already"):
        session.start()
    assert enough.wait(30.0)
    session.unlisten(listen)
    session.stop()
    assert not session.running
    assert [f.frame for f in frames] == list(range(1, len(frames) + 1))


def test_edits_are_answered(session):
    answers = []
    session.edit(schema.Mass("ball", 2.0), answers.append)
    session.edit(schema.Mass("moon", 2.0), answers.append)
    session.step()
    assert answers[0] is None
    assert "moon" in answers[1]
    assert session.edited == 1


@pytest.mark.parametrize(
    "edit",
    [
        schema.Add("huge", "sphere:1e300", 1.0, (0.0, 5.0, 1.0)),
        schema.Add("flat", "box:1e-12:1e-12:1e-12", 1.0, (0.0, 5.0, 1.0)),
        schema.Mass("ball", 1e-300),
    ],
)
def test_an_edit_that_cannot_be_simulated_is_answered_and_costs_no_step(session, edit):
    answers = []
    session.edit(edit, answers.append)
    session.edit(schema.Mass("ball", 2.0), answers.append)
    assert session.step().frame == 1
    assert isinstance(answers[0], str)
    assert answers[1:] == [None]
    assert set(session.simulator.world.scene.objects) == {"ball"}


def test_too_many_edits_are_refused_not_queued(session):
    answers = []
    for _ in range(300):
        session.edit(schema.Mass("ball", 2.0), answers.append)
    assert len(answers) == 44
    assert all("Ask again later" in answer for answer in answers)


def test_a_step_that_fails_does_not_end_the_session(session, monkeypatch):
    good = session.simulator.step
    failures = []

    def step(targets):
        if len(failures) < 3:
            failures.append(1)
            raise RuntimeError("a fault")
        return good(targets)

    monkeypatch.setattr(session.simulator, "step", step)
    done = threading.Event()
    session.listen(lambda frame: done.set())
    session.start()
    assert done.wait(30.0)
    session.stop()
    assert (len(failures), session.trouble) == (3, "")


def test_a_listener_that_fails_harms_nobody(session, caplog):
    heard = []

    def broken(frame):
        raise OSError("no route")

    session.listen(broken)
    session.listen(heard.append)
    for _ in range(3):
        session.step()
    assert len(heard) == 3
    assert len(caplog.records) == 1


def test_starts_are_any_poses(scene):
    """A list, a tuple or an iterator of them, or the first person's alone."""
    there = hp.Pose([0.0, 2.0, 0.3], np.zeros((55, 3)))
    starts = [Session(scene, start=start).newest for start in ([there], iter([there]), there)]
    at = [first.poses["person"].translation for first in starts]
    assert all(np.array_equal(at[0], other) for other in at[1:])


def test_more_starts_than_people_are_refused(scene):
    """Such as a whole motion, of which the first pose was taken."""
    there = hp.Pose([0.0, 2.0, 0.3], np.zeros((55, 3)))
    with pytest.raises(hp.HalfPhysicsError, match="start: found 3 poses, expected at most 2"):
        Session(scene, body=[hp.Body.default()] * 2, start=[there] * 3)


def test_the_first_people_start_where_they_are_put(scene):
    pose = Session(scene).newest.poses["person"]
    there = hp.Pose(np.add(pose.translation, (0.0, -1.5, 0.0)), pose.rotations)
    session = Session(scene, body=[hp.Body.default()] * 2, start=[there])
    np.testing.assert_allclose(session.newest.poses["person0"].translation, there.translation)
    assert len(session.newest.poses) == 2


def test_who_is_blocked_does_not_fall_behind():
    """At a wall the target is the newest pose: nothing is queued, and the state does not grow."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("wall", hp.Box((0.2, 6.0, 3.0)), position=(0.6, 0.0, 1.5))
    session = Session(scene, settings=hp.Settings(blocked="wait"))
    assert session.simulator.settings.blocked == "continue"
    first = session.newest.poses["person"]
    sizes, touched = [], 0
    for i in range(120):
        away = hp.Pose(first.translation + np.array([0.01 * i, 0.0, 0.0]), first.rotations)
        session.offer(IncomingPose("person", away, i / 90.0, None))
        session.step()
        sizes.append(session.simulator.world.stepper.save().size)
        touched += len(session.newest.contacts.part) > 0
    assert touched > 5
    assert max(sizes[60:]) < sizes[30] + 1000, "a queue of 30 poses has 6,000 numbers"


def test_what_a_client_asked_for_before_it_left_ends_with_it(session):
    """A drag that still waits begins, and ends at once: nobody else could end it."""
    answers = []
    session.edit(schema.Drag("ball", (1.0, 1.0, 1.5), (1.0, 1.0, 0.1)), answers.append, "ws:1")
    session.leave("ws:1")
    session.step()
    assert answers == [None]
    assert session._editor.drags == {}


def test_a_start_with_other_axes_is_the_same_person():
    """Frames have axes of the identity: a pose of a y-up file stands where it stood."""
    body, axes = hp.Body.default(), np.array(AXES["y"])
    here = Session(fps=90.0).newest.poses["person"]
    moved = here.translation + (np.eye(3) - axes) @ body.rest_joints[0]
    there = hp.Pose(moved, here.rotations, axes)
    np.testing.assert_allclose(body.joints(there), body.joints(here), atol=1e-12)
    session = Session(start=[there], fps=90.0)
    for frame in (session.newest, session.step()):
        pose = frame.poses["person"]
        np.testing.assert_array_equal(pose.axes, np.eye(3))
        np.testing.assert_allclose(body.joints(pose), body.joints(here), atol=1e-9)
