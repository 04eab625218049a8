"""Hands of several people: the forces bear the load together, within friction."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation import loads, sharing
from halfphysics.adaptation.grips import Place
from halfphysics.adaptation.hands import SIDES, Hand
from halfphysics.adaptation.recorded_holds import recorded_holds
from halfphysics.adaptation.thing import Thing
from support.carries.shared_carry import SharedCase, shared

#: Weight of a thing of 8 kg [N], and friction.
LOAD, FRICTION = np.array([0.0, 0.0, 8.0 * 9.81]), 0.8
#: Of the load, what nobody bears: the penalty that spreads it, and twelve edges for a cone.
REST = 0.02
THING = SimpleNamespace(item=SimpleNamespace(com=np.array([0.05, 0.0, 0.0])))


def at(point, normal):
    """A hand at a point (3,) with the outward normal of the surface there (3,)."""
    zero, eye = np.zeros(3), np.eye(3)
    return Place(None, np.array(point), np.array(normal), zero, eye, zero, eye)


def forces(own, theirs, friction=FRICTION):
    """Forces of all hands (n, 3): what each person finds is the same."""
    out = []
    for mine, others in ((own, theirs), (theirs, own)):
        places, sizes = sharing.shared(mine, others, THING, LOAD, friction)
        out += [size * place.presses for place, size in zip(places, sizes, strict=True)]
    return np.array(out)


def balanced(own, theirs, found):
    points = np.array([place.point for place in (*own, *theirs)]) - THING.item.com
    assert np.linalg.norm(found.sum(axis=0) - LOAD) < REST * np.linalg.norm(LOAD)
    assert np.linalg.norm(np.cross(points, found).sum(axis=0)) < REST * np.linalg.norm(LOAD)


def test_palms_below_a_table_bear_its_weight():
    down = (0.0, 0.0, -1.0)
    own = [at((-0.6, 0.2, 0.0), down), at((-0.6, -0.2, 0.0), down)]
    theirs = [at((0.6, 0.2, 0.0), down), at((0.6, -0.2, 0.0), down)]
    found = forces(own, theirs)
    balanced(own, theirs, found)
    # The centre of mass is nearer to the others: they bear more.
    assert found[2:, 2].sum() > 1.05 * found[:2, 2].sum()
    assert sharing.bears(own[0], LOAD)


def test_palms_at_the_sides_press_against_each_other_with_a_margin():
    own = [at((-0.4, y, 0.0), (0.0, np.sign(y), 0.0)) for y in (0.2, -0.2)]
    theirs = [at((0.4, y, 0.0), (0.0, np.sign(y), 0.0)) for y in (0.2, -0.2)]
    found = forces(own, theirs)
    balanced(own, theirs, found)
    for place, force in zip((*own, *theirs), found, strict=True):
        presses = -force @ place.normal
        rubs = np.linalg.norm(force + presses * place.normal)
        assert presses > 1.9 * rubs / FRICTION
        assert not sharing.bears(place, LOAD)
    # Friction that bears the load needs this much at each side; forces spread over edges need more.
    least = LOAD[2] / FRICTION
    assert least < np.abs(found[:, 1]).sum() / 2.0 < 1.4 * least


def test_two_people_press_a_thing_between_them():
    """Palms at the two ends: neither person's hands oppose each other."""
    own = [at((-0.4, y, 0.0), (-1.0, 0.0, 0.0)) for y in (0.15, -0.15)]
    theirs = [at((0.4, y, 0.0), (1.0, 0.0, 0.0)) for y in (0.15, -0.15)]
    found = forces(own, theirs)
    balanced(own, theirs, found)
    assert (found[:2, 0] > 0.0).all()
    assert (found[2:, 0] < 0.0).all()


def test_hands_that_cannot_bear_it_say_so():
    above = [at((x, 0.0, 0.1), (0.0, 0.0, 1.0)) for x in (-0.4, 0.4)]
    assert sharing.shared(above[:1], above[1:], THING, LOAD, FRICTION) is None


@pytest.fixture(scope="module")
def crate():
    return shared(SharedCase("crate", 0.5, "gap", False))


def holds(take, person):
    body, motion = take.bodies[person], take.motions[person]
    thing = Thing.of(take.sequence().scene.objects[take.name], take.track)
    hands = [Hand.of(body, side) for side in SIDES]
    return thing, recorded_holds(motion, body, hands, thing)


def test_the_others_hands_are_found_while_they_hold(crate):
    thing, (hold,) = holds(crate, 0)
    other = [(crate.motions[1], crate.bodies[1])]
    found = sharing.others_places(other, thing, hold, FRICTION)
    assert len(found) == 2
    assert all(place.point[0] > 0.2 for place in found)  # at their end
    assert sharing.others_places([], thing, hold, FRICTION) == ()


def test_the_load_is_weight_and_acceleration(crate):
    thing, (hold,) = holds(crate, 0)
    load = loads.load(hold, 30.0, np.array([0.0, 0.0, -9.81]))
    weight = thing.item.mass * 9.81
    assert weight < np.linalg.norm(load) < 1.2 * weight
    assert load[2] > 0.99 * np.linalg.norm(load)


def test_a_crate_of_two_needs_half_the_force(crate):
    sequence = crate.sequence()
    motion, body = crate.motions[0], crate.bodies[0]
    alone = hp.adapt(motion, sequence.scene, body, sequence.recorded)
    other = [(crate.motions[1], crate.bodies[1])]
    both = hp.adapt(motion, sequence.scene, body, sequence.recorded, others=other)
    assert both.holds[0].force < 0.85 * alone.holds[0].force
