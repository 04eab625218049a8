"""Numbers that change without a jerk."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.actors.glides import Glide, Spring

DT = 0.001


def test_a_glide_is_there_in_time_and_at_rest():
    glide = Glide(1.0)
    glide.to(3.0, 0.5)
    values = [glide.advance(DT) for _ in range(600)]
    assert values[499] == pytest.approx(3.0, abs=1e-12)
    assert glide.there
    assert glide.speed == 0.0
    assert max(values) == 3.0, "it does not overshoot from rest"


def test_speed_is_continuous_when_the_goal_changes():
    glide, values = Glide(), [0.0]
    glide.to(1.0, 1.0)
    for i in range(1500):
        if i == 400:
            glide.to(-2.0, 0.8)
        values.append(glide.advance(DT))
    speed = np.diff(values) / DT
    assert np.abs(np.diff(speed)).max() < 0.05, "no step of the speed: at most 50 /s^2"
    assert glide.value == -2.0


def test_a_glide_goes_on_from_where_it_was_put():
    glide = Glide()
    glide.put(0.1, 0.1)
    glide.to(0.0, 0.3)
    first = glide.advance(DT)
    assert first == pytest.approx(0.1 + DT * 1.0, rel=1e-2)


def test_a_spring_follows_without_overshoot():
    spring = Spring(0.2)
    values = [spring.advance(1.0, DT) for _ in range(1000)]
    assert values[399] == pytest.approx(0.908, abs=0.01), "91 % after twice its time"
    assert max(values) <= 1.0
    fine, coarse = Spring(0.2), Spring(0.2)
    for _ in range(100):
        fine.advance(1.0, 0.01)
    coarse.advance(1.0, 1.0)
    assert fine.value == pytest.approx(coarse.value, abs=1e-12), "exact for a goal at rest"
