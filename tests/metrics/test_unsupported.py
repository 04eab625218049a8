"""Unsupported weight: people on a floor, above it, and in a jump."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Plane
from halfphysics.metrics.unsupported import unsupported_from
from halfphysics.scene.scene import Scene
from halfphysics.settings import Settings
from halfphysics.simulation.simulate import simulate
from support.people import t_pose


def stood(heights, fps=30.0):
    """A result whose soles are at these heights (T,) [m] above a floor, as asked."""
    low = Body.default().vertices(t_pose(np.zeros((2, 3))), 0)[:, 2].min()
    path = np.zeros((len(heights), 3))
    path[:, 2] = np.asarray(heights) - low
    scene = Scene()
    scene.add_static("floor", Plane())
    asked = t_pose(path, fps)
    result = simulate(asked, scene, settings=Settings(root="stay"))
    person = dataclasses.replace(result.people[0], motion=asked, reference=asked)
    return dataclasses.replace(result, people=(person,))


def test_who_stands_is_carried():
    report = metrics.unsupported_weight(stood(np.full(30, 0.001)))
    assert report.percent == 0.0
    assert report.weight_percent < 1.0
    assert report.missing.max() < 5.0


def test_who_hangs_in_the_air_is_not():
    report = metrics.unsupported_weight(stood(np.full(30, 0.3)))
    assert report.percent == 100.0
    assert report.weight_percent == pytest.approx(100.0, abs=0.1)
    assert report.unsupported.all()


def test_a_jump_counts_for_nothing():
    t = np.arange(61) / 60.0 - 0.2
    flight = np.where((t > 0) & (t < 0.6), 0.5 * 9.81 * t * (0.6 - t), 0.0) + 0.001
    report = metrics.unsupported_weight(stood(flight, 60.0))
    in_air = (t > 0.12) & (t < 0.48)
    assert not report.unsupported[in_air].any()


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0.0, 120.0), st.booleans()), min_size=1, max_size=40))
def test_shares_of_the_frames_that_count(frames):
    missing = np.array([m for m, _ in frames])
    in_air = np.array([a for _, a in frames])
    report = unsupported_from(missing, in_air)
    ground = missing[~in_air]
    if not len(ground):
        assert (report.percent, report.weight_percent) == (0.0, 0.0)
        return
    assert report.percent == pytest.approx(100.0 * (ground > 5.0).mean())
    assert report.weight_percent == pytest.approx(ground.mean())


def test_no_such_person():
    with pytest.raises(InputError, match="person"):
        metrics.unsupported_weight(stood(np.zeros(3)), 1)
