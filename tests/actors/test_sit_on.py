"""Sitting down, sitting, and standing up."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Person, Seen, SitOn, StandUp, WalkTo, play
from halfphysics.actors.seat import seat_pelvis
from support.acted import body, range_excess, slide, smooth, until_done

SIT = SitOn((-1.0, 0.0), height=0.44, heading=0.0, stay=1.0)


def hands_over_thighs(motion):
    """At the end knuckles are 7 to 20 cm above the middle lines of the thighs, and over them."""
    joints = dict(zip(hp.JOINT_NAMES, body().joints(motion)[-1], strict=True))
    for side in ("left", "right"):
        hip, knee = joints[f"{side}_hip"], joints[f"{side}_knee"]
        along = (knee - hip) / np.linalg.norm(knee - hip)
        hand = joints[f"{side}_middle1"] - hip
        above = hand - (hand @ along) * along
        assert 0.5 < hand @ along / np.linalg.norm(knee - hip) < 1.0
        assert 0.07 < above[2] < 0.2
        assert abs(above[1]) < 0.1


def test_it_sits_where_it_was_told_and_stands_up():
    person = Person(body(), place=(0.5, 0.0), goals=[SIT])
    motion = until_done(person)
    assert person.sits
    pelvis = body().joints(motion)[-1, 0]
    np.testing.assert_allclose(pelvis[:2], SIT.place, atol=0.02)
    assert 0.06 < pelvis[2] - SIT.height < 0.13
    hands_over_thighs(motion)
    person.then(StandUp())
    poses = [person.next(1.0 / 30.0, Seen()) for _ in range(90)]
    assert person.done
    assert person.stands
    assert body().joints(poses[-1])[0, 2] > 0.85
    assert range_excess(motion) < 1e-9
    assert smooth(motion)
    assert slide(motion).max() < 0.002


def test_who_sits_stands_up_before_walking():
    person = Person(body(), goals=[SIT, WalkTo((1.0, 0.0))])
    motion = until_done(person)
    assert smooth(motion)
    assert slide(motion).max() < 0.002
    assert person.place[0] == pytest.approx(1.0, abs=1e-3)


def test_a_seat_carries_it():
    """In the simulation it rests on the seat, and feet and pelvis stay where they were asked."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("seat", hp.Box((0.5, 0.8, 0.44)), position=(-1.2, 0.0, 0.22))
    result = play(Person(body(), goals=[SIT], scene=scene), scene, seconds=10.0)
    touched = result.contacts.other == result.names.index("seat")
    parts = {hp.JOINT_NAMES[k] for k in np.unique(result.contacts.part[touched])}
    assert parts <= {"pelvis", "left_hip", "right_hip"}
    assert parts
    off = result.motion.translation[-1] - result.reference.translation[-1]
    assert np.linalg.norm(off) < 0.03


def test_a_seat_behind_walls_is_given_up():
    scene = hp.Scene()
    for k, (x, y) in enumerate(((2.0, 0.0), (6.0, 0.0), (4.0, 2.0), (4.0, -2.0))):
        size = (0.2, 4.0, 2.0) if y == 0.0 else (4.0, 0.2, 2.0)
        scene.add_static(f"wall{k}", hp.Box(size), position=(x, y, 1.0))
    goal = SitOn((4.0, 0.0))
    person = Person(body(), scene=scene, goals=[goal])
    person.reset()
    for _ in range(13 * 30):
        person.next(1.0 / 30.0, Seen())
    assert not person.done
    assert person.stands
    assert person.given_up[0].goal == goal
    assert "no way leads there" in person.given_up[0].reason


def test_impossible_seats_are_refused():
    with pytest.raises(hp.errors.InputError, match=r"SitOn: height: expected a number from 0.3"):
        SitOn((0.0, 0.0), height=0.1)


def simulated(goal, own, most=20.0):
    """A person sits on a bench 0.5 m deep, its place 0.15 m behind the edge; person and pelvis."""
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_static("bench", hp.Box((1.2, 0.5, goal.height)), position=(0, 1.5, goal.height / 2))
    person = Person(own, place=(0.0, 0.6), heading=-1.5, scene=scene, goals=[goal])
    sim = hp.Simulator(scene, body=own, settings=hp.actors.SETTINGS, fps=30)
    frame = sim.reset(person.reset())
    for i in range(round(30 * most)):
        frame = sim.step(person.next(1.0 / 30.0, Seen.of(sim, frame, time=i / 30.0)))
        if not person.goals:
            break
    return person, own.joints(frame.poses[0])[0]


@pytest.mark.parametrize("height", [0.3, 0.45, 0.55])
def test_bodies_come_to_rest_on_the_seat(height):
    """On one of 0.55 m it was 6 cm off: its thighs were in the edge."""
    goal = SitOn((0.0, 1.4), height=height, heading=-math.pi / 2, stay=1.0)
    person, pelvis = simulated(goal, body())
    assert person.done
    np.testing.assert_allclose(pelvis, seat_pelvis(goal.place, height, person.leg), atol=0.04)


@pytest.mark.parametrize(("soft", "height"), [("mattress", 0.4), ("pillow", 0.45)])
def test_who_sinks_into_a_seat_sits_on_it(soft, height):
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    seat = hp.Box((0.6, 0.8, height))
    scene.add_static("seat", seat, position=(1.5, 0.0, height / 2), soft=soft)
    goal = SitOn((1.4, 0.0), height=height, heading=math.pi, stay=1.0)
    person = Person(body(), goals=[goal], scene=scene)
    result = hp.actors.play(person, scene, seconds=8.0)
    assert person.done
    assert person.given_up == ()
    pelvis = body().joints(result.motion)[:, 0]
    wanted = np.array(seat_pelvis(goal.place, height, person.leg))
    deepest = pelvis[pelvis[:, 2].argmin()]
    assert deepest[2] < wanted[2] - 0.1
    np.testing.assert_allclose(deepest[:2], wanted[:2], atol=0.06)


@pytest.mark.parametrize(("stature", "height"), [(None, 0.7), (1.2, 0.45)])
def test_a_seat_that_is_too_high_is_given_up(stature, height):
    """It was done, with a body that leaned on the edge."""
    own = body() if stature is None else hp.Body.default(stature=stature)
    goal = SitOn((0.0, 1.4), height=height, heading=-math.pi / 2, stay=1.0)
    person, _ = simulated(goal, own)
    assert not person.done
    (given_up,) = person.given_up
    assert given_up.reason.startswith("(0, 1.4) was not sat on: the body is 0.")
