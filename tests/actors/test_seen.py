"""What a person sees of a frame."""

from __future__ import annotations

import numpy as np

import halfphysics as hp
from halfphysics.actors import Person, Seen
from support.acted import body


def two_people_and_a_ball():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object(
        "ball", hp.Sphere(0.1), mass=5.0, position=(0.45, 0.0, 1.2), velocity=(-6.0, 0.0, 0.0)
    )
    sim = hp.Simulator(scene, body=[body(), body()], fps=30.0)
    poses = [Person(body(), place=(x, 0.0)).reset() for x in (0.0, 2.0)]
    return sim, sim.reset(poses), poses


def test_a_person_sees_itself_the_others_and_objects():
    sim, frame, poses = two_people_and_a_ball()
    seen = Seen.of(sim, frame, 1, time=0.5)
    assert seen.time == 0.5
    np.testing.assert_allclose(seen.pose.translation, poses[1].translation, atol=1e-12)
    assert set(seen.others) == {0}
    np.testing.assert_allclose(seen.others[0].pelvis, body().joints(poses[0])[0], atol=1e-12)
    assert set(seen.objects) == {"ball"}
    assert (seen.push == 0.0).all()
    assert seen.touched == frozenset()


def test_a_push_is_seen_by_who_is_pushed():
    sim, frame, poses = two_people_and_a_ball()
    for _ in range(6):
        frame = sim.step(poses)
        seen = Seen.of(sim, frame, 0)
        if "ball" in seen.touched:
            break
    assert seen.push[0] < -3.0, "[N s], backwards"
    assert (np.linalg.norm(seen.touched_at - [0.15, 0.0, 1.2], axis=1) < 0.3).all()
    assert not Seen.of(sim, frame, 1).touched


def test_without_contacts_nothing_is_touched():
    assert (Seen().push == 0.0).all()
    assert len(Seen().touched_at) == 0
    assert not Seen().touched


def test_a_person_sees_what_it_holds_itself():
    scene = hp.Scene()
    scene.add_static("floor", hp.Plane())
    scene.add_object("ball", hp.Sphere(0.05), mass=0.2, position=(0.0, 3.0, 0.05))
    pair = [Person(body()), Person(body(), place=(2.0, 0.0))]
    sim = hp.Simulator(scene, body=[body(), body()], fps=30)
    sim.reset([person.reset() for person in pair])
    sim.attach("ball", "right_wrist", 1)
    frame = sim.step([person.next(1.0 / 30.0, Seen()) for person in pair])
    assert Seen.of(sim, frame, 0).held == frozenset()
    assert Seen.of(sim, frame, 1).held == {"ball"}
