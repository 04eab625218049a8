"""Net forces on people by hand."""

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
from halfphysics.metrics.net_force import net_force_from
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.people import t_pose
from support.results.random_result import touching

HAND, FOOT = JOINT_INDEX["left_wrist"], JOINT_INDEX["left_foot"]


@pytest.fixture(scope="module")
def quiet():
    scene = Scene()
    scene.add_static("floor", Plane(offset=-3.0))
    return simulate(t_pose(np.zeros((30, 3))), scene)


def with_contacts(result, *columns):
    return dataclasses.replace(result, contacts=touching(*columns))


def test_forces_are_impulses_over_frames_and_cancel(quiet):
    """30 fps: 10 N s are 300 N; two that oppose each other are none."""
    touched = with_contacts(
        quiet,
        [5, 5, 9, 9],
        [HAND, FOOT, HAND, FOOT],
        [0, 0, 0, 0],
        [[0.0, 6, 0], [0.0, 0, 8], [3.0, 0, 0], [-3.0, 0, 0]],
    )
    report = metrics.net_force(touched)
    assert report.weight == pytest.approx(9.81 * Body.default().variant.mass)
    assert report.force[5] == pytest.approx([0.0, 180.0, 240.0])
    assert report.force[9] == pytest.approx([0.0, 0.0, 0.0])
    assert report.peak == pytest.approx(300.0)
    assert report.peak_weights == pytest.approx(300.0 / report.weight)
    assert report.window_weights == pytest.approx(150.0 / report.weight)  # two frames
    assert report.sustained_weights == 0.0  # one frame of 33 ms


def test_nothing_touched(quiet):
    report = metrics.net_force(quiet)
    assert (report.peak, report.window_weights, report.sustained_weights) == (0.0, 0.0, 0.0)
    with pytest.raises(InputError, match="person"):
        metrics.net_force(quiet, 1)


@pytest.mark.parametrize(("fps", "frames"), [(30.0, 2), (20.0, 1), (120.0, 6), (240.0, 12)])
def test_what_is_held_for_50_ms(fps, frames):
    """A force that lasts one frame less than 50 ms is an impact, however large."""
    force = np.zeros((40, 3))
    force[5 : 5 + frames, 2] = 900.0
    force[20 : 20 + frames - 1, 2] = 9000.0
    report = net_force_from(force, fps, 600.0)
    assert report.sustained_weights == pytest.approx(1.5)
    assert report.peak_weights == pytest.approx(15.0 if frames > 1 else 1.5)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.floats(-1e4, 1e4), min_size=6, max_size=60),
    st.sampled_from([30.0, 60.0, 120.0]),
)
def test_the_shorter_the_time_the_larger(values, fps):
    force = np.array(values[: len(values) // 3 * 3]).reshape(-1, 3)
    report = net_force_from(force, fps, 600.0)
    assert report.peak_weights >= report.window_weights - 1e-9
    assert report.peak_weights >= report.sustained_weights
    assert report.peak == pytest.approx(600.0 * report.peak_weights)
