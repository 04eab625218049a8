"""Changes between actors keep pose, velocity and standing feet."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.actors import Clip, Mixed, Person, Seen, SitOn, WalkTo
from halfphysics.actors.footprints import feet_of
from halfphysics.actors.inertia import Inertia, State
from halfphysics.base import rotations as rot
from support.acted import FPS, body, frames

#: What a change may add to the accelerations of the clips themselves [m/s^2].
CHANGES = 60.0


@pytest.fixture(scope="module")
def walk():
    return hp.scenarios.load("walk_into_wall").motion[20:80]


def mixed(walk):
    return Mixed(
        body(),
        {
            "walk": Clip(walk, body(), loop=True),
            "back": Clip(walk, body(), loop=True, mirror=True, speed=0.8),
            "person": Person(body()),
        },
    )


def acceleration(motion):
    joints = body().joints(motion)[:, :22]
    return np.linalg.norm(np.diff(joints, n=2, axis=0), axis=2).max(axis=1) * FPS**2


@pytest.mark.parametrize("at", [33, 41, 50, 58])
@pytest.mark.parametrize("to", ["back", "person"])
def test_a_change_is_continuous(walk, to, at):
    actor = mixed(walk)
    motion = frames(actor, 110, each=lambda i: actor.play(to) if i == at else None)
    own = acceleration(frames(Clip(walk, body(), loop=True), 110)).max()
    assert actor.name == to
    assert acceleration(motion).max() < own + CHANGES
    place = body().joints(motion)[:, 0]
    assert np.linalg.norm(np.diff(place, axis=0), axis=1).max() * FPS < 2.0, "no jump"


def test_a_standing_foot_stays(walk):
    """While the person that took over stands, its feet do not move at all."""
    actor = mixed(walk)

    def change(i):
        if i == 45:
            actor.play("person", fade=0.5)

    motion = frames(actor, 150, each=change)
    toes = body().joints(motion)[:, [hp.JOINT_NAMES.index(f"{s}_foot") for s in ("left", "right")]]
    still = np.linalg.norm(np.diff(toes[-30:], axis=0), axis=2)
    assert still.max() < 1e-4


def test_a_person_takes_over_on_the_feet_it_finds(walk):
    actor = mixed(walk)
    for i in range(60):
        if i == 40:
            before = feet_of(actor._shown, body())
            actor.play("person")
            actor.actors["person"].do(WalkTo((3.0, 0.0)))
            pose = actor.next(1.0 / FPS, Seen())
            person = actor.actors["person"]
            for side, hold in zip(("left", "right"), before, strict=True):
                if person._walker._step.side != side:
                    np.testing.assert_allclose(person._walker.hold(side)[:2], hold[:2], atol=1e-9)
        else:
            pose = actor.next(1.0 / FPS, Seen())
    assert np.isfinite(pose.translation).all()


def test_inertia_starts_as_the_old_and_ends_as_the_new():
    rng = np.random.default_rng(0)
    a, b = (State(rng.normal(size=3), rot.exp(rng.normal(0, 0.3, (55, 3)))) for _ in range(2))
    inertia = Inertia((a, a), (b, b), 0.1, 0.4)
    start = inertia.at(0.0, b)
    np.testing.assert_allclose(start.root, a.root, atol=1e-12)
    assert float(np.abs(np.sum(start.quats * a.quats, axis=1)).min()) > 1.0 - 1e-12
    assert inertia.at(0.4, b) is b
    # With rates: the first step goes on at the old speed.
    later = State(a.root + np.array([0.01, 0.0, 0.0]), a.quats)
    moving = Inertia((a, later), (b, b), 0.01, 0.4)
    np.testing.assert_allclose(
        (moving.at(1e-4, b).root - a.root) / 1e-4, [1.0, 0.0, 0.0], atol=0.01
    )


def test_equal_bits(walk):
    runs = [
        frames(actor, 90, each=lambda i, a=actor: a.play("back") if i == 30 else None)
        for actor in (mixed(walk), mixed(walk))
    ]
    assert runs[0].rotations.tobytes() == runs[1].rotations.tobytes()


def test_what_cannot_be_played_is_refused(walk):
    with pytest.raises(hp.errors.InputError, match="there is no actor 'wlak'; did you mean 'walk'"):
        mixed(walk).play("wlak")
    with pytest.raises(hp.errors.InputError, match="actors that can begin anywhere"):
        Mixed(body(), {})


def test_a_person_that_sat_takes_over_standing(walk):
    """It flew back to its seat, 8 m in a third of a second."""
    person = Person(body(), goals=[SitOn((1.0, 0.0), heading=np.pi, stay=100.0)])
    actor = Mixed(body(), {"person": person, "walk": Clip(walk, body(), loop=True)})
    actor.reset()
    for _ in range(330):
        actor.next(1.0 / FPS, Seen())
    assert person.sits
    pelvis = []
    for name, count in (("walk", 150), ("person", 30)):
        actor.play(name, fade=0.4)
        poses = [actor.next(1.0 / FPS, Seen()) for _ in range(count)]
        pelvis += [body().joints(pose)[0] for pose in poses]
    assert person.stands
    ways = np.linalg.norm(np.diff(pelvis[150:], axis=0)[:, :2], axis=1)
    assert ways.max() * FPS < 2.0, "no faster than it walks"
    assert pelvis[-1][2] > 0.8, "it stands"
