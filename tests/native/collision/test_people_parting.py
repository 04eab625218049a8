"""People who start overlapping are taken apart: one displacement, of the lighter person."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.geometry.shapes import Box
from support.as_it_is import as_it_is
from support.people import along_x

pytestmark = pytest.mark.filterwarnings("ignore:the start is not clear")

#: What a person moves besides the way out: the way to a standstill [m].
RUN_OUT = 0.03
#: The speed of the way out [m/s], and what the joints' deviation adds to it.
SPEED, EXTRA = 0.5, 0.01


@pytest.fixture(scope="module")
def body():
    return hp.Body.default()


@pytest.fixture(scope="module")
def child():
    return hp.Body.default(stature=1.2)


def displaced(result, motions):
    """How far each person is from the motion, (people, T, 3) [m]."""
    pairs = zip(result.people, motions, strict=True)
    return np.array([p.motion.translation - m.translation for p, m in pairs])


def fastest(person):
    steps = np.linalg.norm(np.diff(person.motion.translation, axis=0), axis=1)
    return steps.max() * person.motion.fps


@pytest.mark.parametrize("contact", ["skin", "parts"])
@pytest.mark.parametrize("drive", [{}, {"drive_time": None}, {"strength": "human"}], ids=str)
@pytest.mark.parametrize("ahead", [0.0, 0.12], ids=["in one place", "half overlapping"])
def test_they_are_apart_within_a_second(body, ahead, drive, contact):
    motions = [along_x(0.0, 45, start=0.0), along_x(0.0, 45, start=ahead)]
    settings = as_it_is(contact=contact, **drive)
    result = hp.simulate(motions, body=[body, body], settings=settings)
    assert len(result.breaches) == 0
    first, last = result.inside.frame.min(), result.inside.frame.max()
    assert first == 0
    assert last < 30
    assert (np.diff(result.inside.depth) < 0).all()
    # One follows the motion exactly; the other goes as far as it must, no faster than asked.
    off = np.linalg.norm(displaced(result, motions), axis=2)
    assert off[0].max() == 0.0
    assert result.inside.depth[0] < 0.3
    assert abs(off[1, -1] - result.inside.depth[0]) < RUN_OUT
    assert fastest(result.people[1]) <= SPEED + EXTRA
    for person, motion in zip(result.people, motions, strict=True):
        np.testing.assert_allclose(person.motion.rotations, motion.rotations, atol=1e-9)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_child_is_displaced_not_the_adult(body, child, order):
    bodies = [(body, child)[k] for k in order]
    motions = [along_x(0.0, 45, start=0.0), along_x(0.0, 45, start=0.05)]
    result = hp.simulate(motions, body=bodies, settings=as_it_is())
    off = np.linalg.norm(displaced(result, motions), axis=2)[:, -1]
    assert off[order.index(0)] == 0.0
    assert 0.05 < off[order.index(1)] < 0.4
    assert len(result.breaches) == 0


def test_where_a_wall_holds_the_child_the_adult_goes(body, child):
    motions = [along_x(0.0, 60, start=0.0), along_x(0.0, 60, start=0.1)]
    free = displaced(hp.simulate(motions, body=[body, child], settings=as_it_is()), motions)[1, -1]
    behind = np.sign(free[0]) * 0.2 + 0.1
    scene = hp.Scene()
    scene.add_static("wall", Box((0.02, 2.0, 4.0)), position=(behind, 0.0, 0.0))
    result = hp.simulate(motions, scene, body=[body, child], settings=as_it_is())
    off = np.linalg.norm(displaced(result, motions), axis=2)[:, -1]
    assert abs(free[1]) < 0.7 * abs(free[0])  # towards the wall
    assert len(result.breaches) == 0
    assert result.inside.frame.max() < 30
    assert off[0] > 0.02
    assert off[1] < np.linalg.norm(free)


def test_who_walks_out_of_it_is_not_thrown(body):
    motions = [along_x(0.0, 16, start=0.0), along_x(2.0, 16, start=0.02)]
    result = hp.simulate(motions, body=[body, body], settings=as_it_is())
    assert max(fastest(p) for p in result.people) < 3.0


def test_who_walks_into_it_is_turned_away(body):
    """Displaced against the motion; from then on the two are solid to each other."""
    motions = [along_x(0.0, 60, start=0.0), along_x(-0.3, 60, start=0.15)]
    result = hp.simulate(motions, body=[body, body], settings=as_it_is())
    assert len(result.breaches) == 0
    assert result.inside.frame.max() < 30
    apart = result.people[1].motion.translation - result.people[0].motion.translation
    assert np.linalg.norm(apart[-1]) > 0.15


def test_a_state_saved_meanwhile_goes_on_to_the_bit(body):
    poses = [along_x(0.0, 3, start=0.0)[0]] * 2
    simulator = hp.Simulator(body=[body, body])
    simulator.reset(poses)
    for _ in range(5):
        simulator.step(poses)
    state = simulator.get_state()
    ends = []
    for _ in range(2):
        simulator.set_state(state)
        frames = [simulator.step(poses) for _ in range(20)]
        ends.append([p.translation for p in frames[-1].poses])
    np.testing.assert_array_equal(*ends)


def test_it_is_said(body):
    motion = along_x(0.0, 3, start=0.0)
    with pytest.warns(hp.HalfPhysicsWarning, match=r"person1's .* inside person0"):
        hp.simulate([motion, motion], body=[body, body])
