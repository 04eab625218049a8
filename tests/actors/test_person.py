"""A person: its queue of goals, what it tells, copies."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Actor, Clip, Mixed, Person, ReachFor, Seen, Wait, WalkTo
from support.acted import body


def run(person, count):
    return [person.next(1.0 / 30.0, Seen()) for _ in range(count)]


def test_actors_are_actors():
    motion = hp.scenarios.load("walk_into_wall").motion
    clip = Clip(motion, body())
    assert isinstance(clip, Actor)
    assert isinstance(Person(body()), Actor)
    assert isinstance(Mixed(body(), {"walk": clip}), Actor)
    assert not isinstance(motion, Actor)


def test_goals_follow_each_other_and_can_be_replaced():
    first, second, third = Wait(0.5), WalkTo((1.0, 0.0)), Wait(0.2)
    person = Person(body(), goals=[first])
    person.reset()
    person.then(second)
    assert person.goals == (first, second)
    run(person, 20)
    assert person.goals == (second,)
    person.do(third)
    assert person.goals == (third,)
    run(person, 60)
    assert person.done
    assert person.place[0] < 0.9, "the walk was broken off"


def test_reset_begins_again():
    person = Person(body(), place=(1.0, 2.0), heading=0.5, goals=[WalkTo((3.0, 2.0))])
    start = person.reset()
    run(person, 40)
    person.do(Wait(9.0))
    again = person.reset()
    np.testing.assert_array_equal(start.rotations, again.rotations)
    assert person.goals == (WalkTo((3.0, 2.0)),)
    assert person.place == (1.0, 2.0)
    assert person.heading == 0.5


def test_copies_go_on_as_the_original():
    """Also in the middle of a step and of a reach."""
    person = Person(body(), goals=[WalkTo((1.0, 0.5)), ReachFor((1.5, 0.5, 1.2))])
    person.reset(5)
    run(person, 33)
    others = [copy.deepcopy(person), pickle.loads(pickle.dumps(person))]
    expected = [pose.rotations.tobytes() for pose in run(person, 90)]
    for other in others:
        assert [pose.rotations.tobytes() for pose in run(other, 90)] == expected


def test_who_stands_is_never_quite_still():
    person = Person(body())
    person.reset()
    poses = run(person, 120)
    moved = np.ptp([pose.translation for pose in poses], axis=0)
    assert 0.001 < moved.max() < 0.03


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Person(body(), place=(1.0, 2.0, 3.0)), "Person: place: expected 2 finite numbers"),
        (lambda: Person(body(), heading="north"), "Person: heading: expected a number"),
        (lambda: Person("tall"), "body: found 'tall', expected a halfphysics.Body"),
        (lambda: Person(body(), scene="room.yaml"), r"scene: found 'room\.yaml'.*Scene\.load"),
        (lambda: Person(body(), goals="walk"), "goals: expected goals such as"),
        (lambda: Person(body(), goals=[WalkTo]), "goals: expected goals such as"),
        (lambda: Person(body()).do(None), "goals: expected goals such as"),
        (lambda: Person(body()).then(7), "goals: expected goals such as"),
        (lambda: Person(body()).next(float("nan"), Seen()), "Person.next: dt: expected a number"),
        (lambda: Person(body()).next(1 / 30, None), "Person.next: expected what it sees"),
        (
            lambda: Person(body(), goals=[WalkTo((1e300, 0.0))]).next(1 / 30, Seen()),
            "found a place 1e.300 m away",
        ),
        (lambda: Person(body()).reset(-1), "Person.reset: expected a seed of at least 0, found -1"),
    ],
)
def test_impossible_people_are_refused(make, words):
    with pytest.raises(hp.errors.InputError, match=words):
        make()


class Replaces:
    """A goal that tells the person others, and says what it then says."""

    def __init__(self, says):
        self.says = says

    def task(self):
        return self

    def go_on(self, me):
        me.do(WalkTo((1.0, 0.0)), Wait(1.0))
        return self.says

    def end(self, me):
        pass


@pytest.mark.parametrize("says", [True, False])
def test_a_task_that_tells_other_goals_is_replaced_by_all_of_them(says):
    person = Person(body(), goals=[Replaces(says)])
    run(person, 1)
    assert person.goals == (WalkTo((1.0, 0.0)), Wait(1.0))
    run(person, 200)
    assert person.done
    assert person.place.x == pytest.approx(1.0, abs=1e-3)
