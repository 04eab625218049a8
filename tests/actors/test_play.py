"""Actors in a scene give a result: their reference, and what physics made of it."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Clip, Person, Wait, WalkTo, play
from support.acted import body


def floor():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    return scene


def test_a_result_is_that_of_simulate():
    """A clip does not react: played in a scene, it is simulated as by `simulate`."""
    motion = hp.scenarios.load("walk_into_wall").motion[:45]
    scene = floor()
    scene.add_static("wall", hp.Box((0.1, 3.0, 2.4)), position=(1.2, 0.0, 1.2))
    settings = hp.Settings(blocked="continue")
    played = play(Clip(motion, body()), scene, seconds=44 / 30, body=body(), settings=settings)
    same = hp.simulate(played.reference, scene, body=body(), settings=settings)
    assert played.motion.rotations.tobytes() == same.motion.rotations.tobytes()
    assert played.motion.translation.tobytes() == same.motion.translation.tobytes()
    np.testing.assert_array_equal(played.contacts.impulse, same.contacts.impulse)
    np.testing.assert_array_equal(played.clearance, same.clearance)


def test_objects_are_pushed_between_frames_and_seen():
    scene = floor()
    scene.add_object("ball", hp.Sphere(0.11), mass=0.4, position=(3.0, 0.0, 0.11))

    def kick(sim, time):
        if time == 0.0:
            sim.set_velocity("ball", (0.0, 1.0, 0.0))

    person = Person(body(), goals=[hp.actors.LookAt("ball", seconds=5.0)])
    result = play(person, scene, seconds=1.0, each=kick)
    assert result.objects["ball"].position[-1, 1] > 0.5
    assert person.seen.objects["ball"][0][1] > 0.5
    assert len(result) == 31


def test_results_are_saved_and_have_bodies_of_their_own(tmp_path):
    pair = [Person(body()), Person(hp.Body.default(stature=1.55), place=(2.0, 0.0))]
    result = play(pair, floor(), seconds=0.5)
    assert result.people[1].body.stature == pytest.approx(1.55)
    result.save(tmp_path / "pair.npz")
    again = hp.Result.load(tmp_path / "pair.npz")
    np.testing.assert_array_equal(
        again.people[1].motion.rotations, result.people[1].motion.rotations
    )


def test_a_scene_that_changes_is_refused():
    scene = floor()
    scene.add_object("cup", hp.Cylinder(0.04, 0.1), mass=0.2, position=(0.5, 0.0, 1.0))
    with pytest.raises(hp.errors.InputError, match="play: the people and objects of the scene"):
        play(Person(body()), scene, seconds=0.5, each=lambda sim, time: sim.attach("cup"))


@pytest.mark.parametrize(
    ("actors", "seconds", "words"),
    [
        ([], 1.0, "play: expected actors"),
        ("walk", 1.0, "play: expected actors"),
        (None, 0.0, "play: seconds: expected a number above 0"),
    ],
)
def test_impossible_plays_are_refused(actors, seconds, words):
    cast = Person(body(), goals=[WalkTo((1.0, 0.0))]) if actors is None else actors
    with pytest.raises(hp.errors.InputError, match=words):
        play(cast, floor(), seconds=seconds)


def test_an_actor_plays_one_person_by_whole_seeds():
    person = Person(body())
    with pytest.raises(hp.errors.InputError, match="one actor twice"):
        play([person, person], floor(), seconds=0.5)
    with pytest.raises(hp.errors.InputError, match="expected a seed of at least 0, found 'x'"):
        play(person, floor(), seconds=0.5, seed="x")


def test_a_clip_is_simulated_with_its_own_body():
    """It was the default body."""
    small = hp.Body.default(stature=1.55)
    motion = hp.scenarios.load("walk_into_wall").motion
    result = play(Clip(motion, small), floor(), seconds=0.2)
    assert result.people[0].body.stature == pytest.approx(1.55)


def test_goals_told_before_are_played():
    """Each time; and those of an episode are not kept for the next one."""
    person = Person(body())
    person.do(WalkTo((0.6, 0.0)))
    person.then(Wait(0.1))
    for _ in range(2):
        play(person, floor(), seconds=3.0)
        assert person.done
        np.testing.assert_allclose(person.place, (0.6, 0.0), atol=0.01)
    person.reset()
    person.then(Wait(9.0))
    person.reset()
    assert person.goals == (WalkTo((0.6, 0.0)), Wait(0.1))
