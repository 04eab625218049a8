"""Goals of the hands: points are reached within ranges, things are handed over."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import HandOver, Other, Person, ReachFor, Seen, Wait
from support.acted import body, range_excess, slide, smooth, until_done

RNG = np.random.default_rng(1)
POINTS = RNG.uniform((0.2, -0.5, 0.2), (0.7, 0.5, 1.8), (12, 3))


def nearest(person, side, point, most=400):
    """The least distance of a palm from a point until all is done [m], and the motion."""
    poses, near = [person.reset()], math.inf
    while not person.done and len(poses) < most:
        poses.append(person.next(1.0 / 30.0, Seen()))
        near = min(near, math.dist(person.palm(side), point))
    from halfphysics.actors.play import as_motion

    return near, as_motion(poses, body(), 30.0)


@pytest.mark.parametrize("k", range(len(POINTS)))
def test_points_around_a_person_are_reached(k):
    point = tuple(POINTS[k].tolist())
    side, palm = ("left", "right")[k % 2], ("in", "down", "up")[k % 3]
    near, motion = nearest(
        Person(body(), goals=[ReachFor(point, hand=side, palm=palm)]), side, point
    )
    assert near < 0.02
    assert range_excess(motion) < 1e-9
    assert slide(motion).max() < 0.002
    assert smooth(motion)


def test_a_far_point_is_walked_to():
    point = (3.0, 1.0, 1.1)
    person = Person(body(), goals=[ReachFor(point, hand="left")])
    near, motion = nearest(person, "left", point)
    assert near < 0.02
    assert 0.3 < math.dist(person.place, point[:2]) < 0.8
    assert smooth(motion)


def test_what_nobody_reaches_is_given_up():
    person = Person(body(), goals=[ReachFor((0.5, 0.0, 3.5))])
    near, _ = nearest(person, "right", (0.5, 0.0, 3.5), most=800)
    assert not person.done
    assert person.goals == ()
    assert [one.reason for one in person.given_up] == ["no arm comes to (0.5, 0.0, 3.5)"]
    assert near > 1.0


def test_the_palm_is_where_the_body_has_it():
    """Of the pose that was given: on the skin of the palm."""
    person = Person(body(), goals=[ReachFor((0.5, -0.1, 1.2), hold=5.0)])
    person.reset()
    for _ in range(90):
        pose = person.next(1.0 / 30.0, Seen())
    wrist = hp.JOINT_NAMES.index("right_wrist")
    parts = [wrist, *(hp.JOINT_NAMES.index(f"right_{f}1") for f in ("index", "middle", "ring"))]
    skin = body().vertices(pose)[np.isin(body().weights.argmax(axis=1), parts)]
    assert np.linalg.norm(skin - person.palm("right"), axis=1).min() < 0.02


def test_an_arm_hangs_again_afterwards():
    person = Person(body(), goals=[ReachFor((0.5, -0.1, 1.2)), Wait(1.5)])
    motion = until_done(person)
    first, last = motion.rotations[0], motion.rotations[-1]
    arm = [hp.JOINT_NAMES.index(f"right_{n}") for n in ("shoulder", "elbow", "wrist", "index1")]
    np.testing.assert_allclose(last[arm], first[arm], atol=1e-6)


def cup_at(place):
    return Seen(objects={"cup": (np.array(place), np.array([1.0, 0.0, 0.0, 0.0]))})


def test_giving_ends_when_the_thing_is_out_of_the_hand():
    person = Person(body(), goals=[HandOver(give="cup")])
    person.reset()
    for _ in range(120):
        person.next(1.0 / 30.0, cup_at(person.palm("right")))
    assert not person.done
    out = person.palm("right")
    assert out[0] > 0.3
    assert 0.9 < out[2] < 1.3, "the hand is held out"
    for _ in range(45):
        person.next(1.0 / 30.0, cup_at((1.2, 0.0, 1.0)))
    assert person.done
    assert person.palm("right")[0] < out[0] - 0.1, "the hand goes back"


def test_taking_ends_with_the_thing_in_the_hand():
    person = Person(body(), goals=[HandOver(take="cup", hand="left", patience=30.0)])
    person.reset()
    for _ in range(60):
        person.next(1.0 / 30.0, cup_at((1.5, 0.0, 1.0)))
    assert not person.done
    for _ in range(60):
        pose = person.next(1.0 / 30.0, cup_at(person.palm("left")))
    assert person.done
    curl = np.linalg.norm(pose.rotations[hp.JOINT_NAMES.index("left_index1")])
    assert curl > 0.3, "its fingers close"


def test_patience_ends():
    """It is not done then, but given up."""
    goal = HandOver(until=lambda seen: False, patience=1.0)
    person = Person(body(), goals=[goal])
    person.reset()
    for _ in range(200):
        person.next(1.0 / 30.0, Seen())
    assert not person.done
    assert person.given_up == ((goal, "nothing came of it within 1 s"),)
    assert person.withdrawn("right")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ReachFor((1.0, 2.0)), "ReachFor: target: expected 3 finite numbers"),
        (lambda: ReachFor((1.0, 2.0, 1.0), hand="both"), "expected 'left' or 'right'"),
        (lambda: ReachFor((1.0, 2.0, 1.0), palm="out"), "expected one of in, down, up"),
        (lambda: HandOver(), "expected one of give=, take= and until="),
        (lambda: HandOver(give="cup", take="cup"), "expected one of give=, take= and until="),
    ],
)
def test_impossible_goals_are_refused(make, words):
    with pytest.raises(hp.errors.InputError, match=words):
        make()


def test_an_unknown_target_is_named():
    person = Person(body(), goals=[ReachFor("cap")])
    person.reset()
    with pytest.raises(hp.errors.InputError, match="does not see 'cap'; it sees 'cup'"):
        person.next(1.0 / 30.0, cup_at((1.0, 0.0, 1.0)))


def test_who_is_told_otherwise_before_it_hands_over_stops_turning():
    person = Person(body(), goals=[HandOver(until=lambda seen: False, to=1)])
    person.reset()
    other = Other(hp.Pose([-2.0, 0.0, 0.9], Person(body()).reset().rotations), body())
    person.next(1.0 / 30.0, Seen(others={1: other}))
    person.do(Wait(5.0))
    for _ in range(120):
        person.next(1.0 / 30.0, Seen())
    assert abs(person.heading) < 0.9, "one step, at most"


@pytest.mark.parametrize("stature", [1.0, 1.9])
def test_children_and_tall_people_sink_by_their_own_legs(stature):
    """Their points are those of the default body, scaled. A child's pelvis was in the floor."""
    own = hp.Body.default(stature=stature)
    size = Person(own).leg / Person(body()).leg
    for height in (0.1, 0.2, 0.4, 0.7):
        x, y, z = 0.35 * size, -0.15 * size, height * size
        person = Person(own, goals=[ReachFor((x, y, z))])
        poses = [person.reset()]
        while not person.done and len(poses) < 400:
            poses.append(person.next(1.0 / 30.0, Seen()))
        assert person.done
        lowest = min(float(own.vertices(pose)[:, 2].min()) for pose in poses[::5])
        # Half a centimetre of a finger, at most.
        assert lowest > -0.005
