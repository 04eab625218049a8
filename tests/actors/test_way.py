"""Reactions: who is blocked goes round, who is pushed comes back, people pass each other."""

from __future__ import annotations

import math

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Other, Person, Seen, Wait, WalkTo, play
from halfphysics.actors.passersby import Passersby
from halfphysics.actors.path import Path, Point
from support.acted import body


def floor():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


def furnished_room():
    """6 x 6 m, a wall with a gap across it, a table, a sofa, a shelf and a chair."""
    scene = floor()
    for name, size, at in (
        ("north", (6.0, 0.1, 2.4), (0.0, 3.0, 1.2)),
        ("south", (6.0, 0.1, 2.4), (0.0, -3.0, 1.2)),
        ("west", (0.1, 6.0, 2.4), (-3.0, 0.0, 1.2)),
        ("east", (0.1, 6.0, 2.4), (3.0, 0.0, 1.2)),
        ("inner", (0.1, 3.6, 2.4), (0.5, 1.2, 1.2)),
        ("table", (1.4, 0.8, 0.74), (-1.2, 0.2, 0.37)),
        ("sofa", (0.9, 2.0, 0.8), (2.3, 1.2, 0.4)),
        ("shelf", (1.2, 0.35, 1.8), (-1.5, 2.7, 0.9)),
        ("chair", (0.45, 0.45, 0.45), (1.3, -1.6, 0.22)),
    ):
        scene.add_static(name, hp.Box(size), position=at)
    return scene


def pelvis(result, person=0):
    its = result.people[person]
    return its.body.joints(its.motion)[:, 0, :2]


def test_a_furnished_room_is_crossed_without_touching_anything():
    scene = furnished_room()
    goal = WalkTo((1.4, 2.2), heading=math.pi / 2)
    person = Person(body(), place=(-2.3, 2.0), heading=-1.5, scene=scene, goals=[goal])
    result = play(person, scene, seconds=11.0)
    assert person.done
    assert person.blocked == 0
    held = {result.names[k] for k in np.unique(result.contacts.other)}
    assert held <= {"floor"}
    feet = body().joints(result.motion)[-1, [7, 8], :2].mean(axis=0)
    assert math.dist(feet, goal.place) < 0.02
    assert abs(math.remainder(person.heading - goal.heading, 2 * math.pi)) < math.radians(5.0)


def test_who_is_blocked_goes_round():
    """The person does not know of the pillar: it has no scene."""
    scene = floor()
    scene.add_static("pillar", hp.Box((0.3, 0.4, 2.0)), position=(1.5, 0.0, 1.0))
    person = Person(body(), goals=[WalkTo((3.5, 0.0))])
    result = play(person, scene, seconds=11.0)
    assert person.blocked >= 1
    assert person.done
    np.testing.assert_allclose(person.place, (3.5, 0.0), atol=0.02)
    assert np.abs(pelvis(result)[:, 1]).max() > 0.4, "beside the pillar"
    assert result.clearance.min() > 0.0


def ram(direction, reach):
    """A box comes from behind `direction`, pushes by `reach` [m] and goes back."""
    way = np.array(direction) / np.linalg.norm(direction)
    time = np.arange(8 * 30 + 1) / 30.0
    away = np.interp(time, [0.0, 0.7, 2.2, 3.2, 4.0], [1.2, 0.6, 0.6 - reach, 0.6 - reach, 1.5])
    scene = floor()
    places = np.concatenate([-away[:, None] * way, np.full((len(time), 1), 1.05)], axis=1)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(time), 1))
    scene.add_moving("ram", hp.Box((0.4, 0.4, 0.7)), places, turns, fps=30)
    return scene


@pytest.mark.parametrize("direction", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)])
def test_who_is_pushed_steps_and_comes_back(direction):
    person = Person(body())
    result = play(person, ram(direction, 0.8), seconds=8.0)
    places = pelvis(result)
    moved = np.linalg.norm(places - places[0], axis=1)
    assert moved.max() > 0.4
    assert moved[-1] < 0.03
    reference = body().joints(result.reference)[:, 0, :2]
    stepped = np.linalg.norm(reference - reference[0], axis=1)
    assert stepped.max() > 0.25, "the reference follows its body"
    assert abs(math.remainder(person.heading, 2 * math.pi)) < 1e-3


def test_two_people_pass_each_other():
    pair = [
        Person(body(), goals=[WalkTo((5.0, 0.0))]),
        Person(body(), place=(5.0, 0.05), heading=math.pi, goals=[WalkTo((0.0, 0.0))]),
    ]
    result = play(pair, floor(), seconds=8.0)
    assert all(person.done for person in pair)
    people = [k for k, name in enumerate(result.names) if name.startswith("person")]
    assert not np.isin(result.contacts.other, people).any(), "they do not touch"
    one, two = pelvis(result, 0), pelvis(result, 1)
    meets = int(np.linalg.norm(one - two, axis=1).argmin())
    assert one[meets, 1] < two[meets, 1], "on the right"


def test_simulated_seeds_give_equal_bits():
    def run():
        return play(Person(body(), goals=[WalkTo((1.0, 0.3))]), ram((1.0, 0.0), 0.7), seconds=3.0)

    first, again = run(), run()
    assert first.motion.rotations.tobytes() == again.motion.rotations.tobytes()
    assert first.motion.translation.tobytes() == again.motion.translation.tobytes()


def test_passersby_are_expected_where_they_go():
    still = Person(body()).reset()
    others = Passersby()
    for k in range(30):
        pose = hp.Pose(still.translation + np.array([3.0, 2.0 - 0.04 * k, 0.0]), still.rotations)
        others.notice(1.0 / 30.0, Seen(others={1: Other(pose, body())}))
    here = Point(0.0, 0.0)
    # It is at y = 0.84 and comes with 1.2 m/s: it will be on the way.
    assert others.in_the_way(Path([here, Point(5.0, 0.0)]), here)
    assert not others.in_the_way(Path([here, Point(-5.0, 0.0)]), here)
    assert not Passersby().in_the_way(Path([here, Point(5.0, 0.0)]), here)
    ahead = max(others.places(here), key=lambda at: -at[1])
    assert ahead[1] == pytest.approx(0.84 - 1.5 * 1.2, abs=0.5)


def ahead(person, frames, seen=None):
    """Some frames without a simulator: its body is where its reference is."""
    for _ in range(frames):
        person.next(1.0 / 30.0, seen or Seen())


@pytest.mark.parametrize("told", ["do", "stop"])
def test_who_is_stopped_on_the_way_stays_there(told):
    """It walked back to where it had last arrived."""
    person = Person(body(), goals=[WalkTo((6.0, 0.0))])
    person.reset()
    ahead(person, 100)
    x = person.place.x
    assert x > 2.0
    if told == "do":
        person.do(Wait(1.0))
    else:
        person.do()
        person.walk(Point(6.0, 0.0), None, 1.2)
        person.stop()
    ahead(person, 300)
    assert person.arrived
    # Two steps at most, of 0.75 m, until feet allow it to stand.
    assert x <= person.place.x < x + 1.5


def test_who_is_pushed_and_told_to_stop_comes_back():
    """It was not on its way: where it stood is where it comes back to."""
    person = Person(body(), goals=[Wait(60.0)])
    person.reset()
    still = person.next(1.0 / 30.0, Seen())
    away = hp.Pose(still.translation + np.array([0.3, 0.0, 0.0]), still.rotations)
    ahead(person, 10, Seen(pose=away))
    assert not person.arrived
    person.stop()
    ahead(person, 150)
    np.testing.assert_allclose(person.place, (0.0, 0.0), atol=0.02)


def until_blocked(tell):
    """A body that stays where it is 1 m from the start; `tell` is called before every frame."""
    person = Person(body())
    pose, far = person.reset(), 0.0
    held = pose
    for _ in range(150):
        tell(person)
        seen = pose if pose.translation[0] < 1.0 else held
        held = seen
        pose = person.next(1.0 / 30.0, Seen(pose=seen))
        far = max(far, float(pose.translation[0] - held.translation[0]))
    return person, far


def test_who_is_told_the_way_in_every_frame_notices_that_it_is_blocked():
    """A heading that changes by 0.1 rad each frame; the reference left its body behind."""
    side = [0.4]

    def tell(person):
        side[0] = -side[0]
        person.walk(Point(5.0, side[0]), None, 1.2)

    person, far = until_blocked(tell)
    assert person.blocked >= 1
    once, least = until_blocked(lambda p: p.goals or p.do(WalkTo((5.0, 0.0))))
    assert once.blocked >= 1
    assert far < least + 0.1


def test_another_way_is_gone_at_once_by_who_is_blocked():
    person, _ = until_blocked(lambda p: p.goals or p.do(WalkTo((5.0, 0.0))))
    person.walk(Point(-3.0, 0.0), None, 1.2)
    assert person.blocked == 0


def test_a_way_of_more_than_50_m_is_looked_for_again_on_the_way():
    """It went straight on beyond 50 m, through walls."""
    scene = floor()
    scene.add_static("wall", hp.Box((0.4, 6.0, 2.0)), position=(60.0, 0.0, 1.0))
    person = Person(body(), scene=scene, goals=[WalkTo((70.0, 0.0), speed=1.8)])
    person.reset()
    for _ in range(60 * 30):
        person.next(1.0 / 30.0, Seen())
        if abs(person.place.x - 60.0) < 1.0:
            assert abs(person.place.y) > 3.0, "beside the wall"
        if not person.goals:
            break
    assert person.done
    np.testing.assert_allclose(person.place, (70.0, 0.0), atol=1e-3)
