"""Floating: people lifted by known heights; PhysDiff's sum by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.geometry.shapes import Box, Mesh, Plane
from halfphysics.metrics.floating import floating_from
from halfphysics.metrics.surface_gaps import carrying_gaps
from halfphysics.scene.scene import Scene
from support.people import t_pose
from support.point_bodies import Ball, Cloud, Drift, Track

NO_FACES = np.zeros((0, 3), dtype=np.int32)


def floor(shape=None):
    scene = Scene()
    scene.add_static("floor", Plane() if shape is None else shape)
    return scene


def standing(heights):
    """Upright people whose soles are at heights (T,) [m]."""
    body = Body.default()
    motion = t_pose(np.zeros((len(heights), 3)))
    low = body.vertices(motion, 0)[:, 2].min()
    path = np.zeros((len(heights), 3))
    path[:, 2] = np.asarray(heights) - low
    return t_pose(path), body


@pytest.mark.parametrize("solid", [False, True])
def test_a_body_lifted_by_20_mm_floats_20_mm(solid):
    motion, body = standing(np.full(8, 0.02))
    shape = Mesh(*Box((4.0, 4.0, 2.0)).triangles()) if solid else Plane(offset=1.0)
    report = metrics.floating(_raised(motion), body, floor(shape))
    assert report.percent == 100.0
    assert report.mean_mm == pytest.approx(20.0, abs=1e-6)
    assert report.max_mm == pytest.approx(20.0, abs=1e-6)
    assert report.gap == pytest.approx(np.full(8, 0.02), abs=1e-9)


def _raised(motion):
    return motion.with_frames(motion.translation + np.array([0.0, 0.0, 1.0]), motion.rotations)


def test_who_stands_or_is_sunk_does_not_float():
    for height in (-0.03, 0.0, 0.004):
        motion, body = standing(np.full(5, height))
        report = metrics.floating(motion, body, floor())
        assert (report.percent, report.mean_mm, report.max_mm) == (0.0, 0.0, 0.0)
        assert report.gap == pytest.approx(np.full(5, height), abs=1e-9)


def test_a_layer_carries_from_its_surface_downwards():
    scene = Scene()
    scene.add_static("mattress", Box((4.0, 4.0, 0.5)), position=(0, 0, -0.25), soft="mattress")
    for height, percent in ((-0.12, 0.0), (0.0, 0.0), (0.02, 100.0)):
        motion, body = standing(np.full(5, height))
        report = metrics.floating(motion, body, scene)
        assert report.percent == percent
        assert report.gap == pytest.approx(np.full(5, height), abs=1e-9)


def test_a_quarter_of_the_frames():
    motion, body = standing([0.0, 0.0, 0.0, 0.04])
    report = metrics.floating(motion, body, floor())
    assert report.percent == 25.0
    assert report.mean_mm == pytest.approx(10.0)
    assert report.floats.tolist() == [False, False, False, True]


def test_a_jump_does_not_float_and_hanging_beside_it_does():
    t = np.arange(49) / 30.0 - 0.5
    z = np.where((t > 0) & (t < 0.6), 0.5 * 9.81 * t * (0.6 - t), 0.0)
    jump, body = standing(z)
    hangs, _ = standing(np.where(z > 0.0, 0.1, 0.0))
    report = metrics.floating(jump, body, floor())
    assert report.airborne.sum() >= 12
    # What is left are frames at the ends of the flight, which the low pass rounds.
    assert report.floats.sum() <= 6
    held = metrics.floating(hangs, body, floor(), reference=hangs)
    assert held.percent > 20.0  # but where it jumps up and down
    same = metrics.floating(hangs, body, floor(), reference=jump)
    assert same.floats.sum() <= 6


def test_furniture_carries_and_a_wall_does_not():
    motion, body = standing(np.full(4, 0.5))
    scene = floor()
    scene.add_static("wall", Box((0.1, 4.0, 4.0)), position=(0.3, 0.0, 1.0))
    assert metrics.floating(motion, body, scene).percent == 100.0
    scene.add_object("crate", Box((1.0, 1.0, 0.5)), mass=5.0, position=(9.0, 0.0, 0.25))
    track = Track(np.tile([0.0, 0.0, 0.25], (4, 1)), np.tile([1.0, 0, 0, 0], (4, 1)))
    on_it = metrics.floating(motion, body, scene, objects={"crate": track})
    assert on_it.percent == 0.0
    assert on_it.gap == pytest.approx(np.zeros(4), abs=1e-9)


def test_nothing_below_counts_as_a_metre():
    motion, body = standing(np.zeros(3))
    report = metrics.floating(motion, body, Scene())
    assert report.percent == 100.0
    assert report.mean_mm == 1000.0


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-0.5, 0.9), min_size=2, max_size=12))
def test_a_cloud_floats_by_its_heights(heights):
    drift = Drift(np.stack([0 * np.array(heights)] * 2 + [np.array(heights)], axis=1))
    cloud = Ball(np.zeros((1, 3)), NO_FACES)
    gap = carrying_gaps(drift, cloud, floor(), np.zeros(1, dtype=int)).whole
    report = floating_from(gap, np.zeros(len(heights), dtype=bool))
    over = np.where(np.array(heights) > 0.005, heights, 0.0)
    assert report.mean_mm == pytest.approx(1000.0 * over.mean(), abs=1e-9)
    assert report.percent == pytest.approx(100.0 * (over > 0.0).mean())


def test_physdiff_by_hand():
    """Four frames: 20 mm in, 4 mm in (tolerated), 10 mm above, far above."""
    points = np.zeros((55, 3))
    path = np.array([[0.0, 0, -0.02], [0.003, 0, -0.004], [0.006, 0, 0.01], [0.006, 0, 0.2]])
    report = metrics.physdiff(Drift(path), Cloud(points))
    assert report.penetrate_mm == pytest.approx(5.0)
    assert report.float_mm == pytest.approx((10.0 + 200.0) / 4)
    assert report.skate_mm == pytest.approx(3.0)
    assert report.phys_err_mm == pytest.approx(5.0 + 52.5 + 3.0)
    sunk = metrics.physdiff(Drift(path), Cloud(points), ground=0.3)
    assert sunk.float_mm == 0.0


@pytest.mark.parametrize(
    "wrong",
    [{"tolerance": -1.0}, {"reference": t_pose(np.zeros((9, 3)))}, {"scene": 3}, {"motion": 4}],
    ids=lambda w: next(iter(w)),
)
def test_impossible_arguments(wrong):
    motion, body = standing(np.zeros(3))
    given = {"motion": motion, "body": body, "scene": floor(), **wrong}
    with pytest.raises(InputError, match=next(iter(wrong))):
        metrics.floating(given.pop("motion"), given.pop("body"), given.pop("scene"), **given)
