"""What a held thing weighs on hands: closed forms of loads and of forces between palms."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from halfphysics.adaptation import loads

#: Arithmetic.
ROUNDING = 1e-9
FPS, FRAMES, MASS, G, FRICTION = 60.0, 240, 6.0, 9.81, 0.8
GRAVITY = np.array([0.0, 0.0, -G])


def held(centre=None, com=(0.0, 0.0, 0.0)):
    """A thing that does not turn, with its centre of mass there (T, 3) [m]."""
    centre = np.zeros((FRAMES, 3)) if centre is None else centre
    thing = SimpleNamespace(
        centre=centre,
        turn=np.tile(np.eye(3), (FRAMES, 1, 1)),
        item=SimpleNamespace(mass=MASS, com=np.array(com)),
    )
    return SimpleNamespace(thing=thing, first=0, last=FRAMES - 1)


def palms(y=0.2, height=0.0):
    """Two palms at the left and right side that press against each other."""
    return tuple(
        SimpleNamespace(
            point=np.array([0.0, side * y, height]), presses=np.array([0.0, -side, 0.0])
        )
        for side in (1.0, -1.0)
    )


def test_what_rests_in_the_hands_loads_them_with_its_weight():
    load = loads.load(held(), FPS, GRAVITY)
    assert np.abs(load - [0.0, 0.0, MASS * G]).max() < ROUNDING


def test_what_is_lifted_loads_them_with_its_largest_acceleration_too():
    """z = a (1 - cos w t) has accelerations up to a w^2, over 0.2 s a little less."""
    t, a, w = np.arange(FRAMES) / FPS, 0.1, 4.0
    lifted = np.zeros((FRAMES, 3))
    lifted[:, 2] = a * (1.0 - np.cos(w * t))
    load = loads.load(held(lifted), FPS, GRAVITY)
    span = 0.2
    most = a * w**2 * (2.0 - 2.0 * np.cos(w * span)) / (w * span) ** 2
    assert load[2] == pytest.approx(MASS * (G + most), rel=1e-3)


def test_two_palms_press_with_twice_what_friction_needs():
    force = loads.between_palms(held(), palms(), np.array([0.0, 0.0, MASS * G]), FRICTION)
    assert force == pytest.approx(2.0 * MASS * G / (2.0 * FRICTION))


def test_what_hangs_beside_the_hands_needs_more_and_what_hangs_below_does_not():
    load, its = np.array([0.0, 0.0, MASS * G]), palms()
    straight = loads.between_palms(held(), its, load, FRICTION)
    below = loads.between_palms(held(com=(0.0, 0.0, -0.3)), its, load, FRICTION)
    beside = loads.between_palms(held(com=(0.08, 0.0, 0.0)), its, load, FRICTION)
    assert below == pytest.approx(straight)
    assert beside == pytest.approx(straight * 0.08 / loads._PALM)


def test_forces_are_human():
    load = np.array([0.0, 0.0, MASS * G])
    assert loads.between_palms(held(), palms(), 100.0 * load, FRICTION) == loads.MOST
    assert loads.between_palms(held(), palms(), 0.01 * load, FRICTION) == loads.LEAST
    assert loads.between_palms(held(), palms(), load, 0.0) == loads.MOST


def test_hands_that_bear_from_below_do_not_press():
    its = tuple(SimpleNamespace(point=p.point, presses=np.zeros(3)) for p in palms())
    assert loads.between_palms(held(), its, np.array([0.0, 0.0, MASS * G]), FRICTION) == 0.0
