"""Sliding in stance: feet that slide by known steps, on a floor and on things that move."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Plane
from halfphysics.metrics.stance import PATCHES, in_stance, sole_patches
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.results.result import ObjectTrack
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.as_it_is import as_it_is
from support.people import t_pose

FRAMES = 12


def standing(height=0.0, base=0.0):
    body = Body.default()
    low = body.vertices(t_pose(np.zeros((2, 3))), 0)[:, 2].min()
    return t_pose(np.tile([0.0, 0.0, base + height - low], (FRAMES, 1)))


@pytest.fixture(scope="module")
def stood():
    """A person who stands on a floor."""
    scene = Scene()
    scene.add_static("floor", Plane())
    return simulate(standing(0.002), scene)


def slid(result, step, reference=None):
    """The result's person moved by `step` [m] from frame to frame."""
    person = result.people[0]
    way = np.arange(FRAMES)[:, None] * np.asarray(step)
    motion = person.motion.with_frames(person.motion.translation + way, person.motion.rotations)
    changed = dataclasses.replace(person, motion=motion, reference=reference or person.reference)
    return dataclasses.replace(result, people=(changed,))


def test_feet_that_slide_3_mm_a_frame(stood):
    report = metrics.stance_slide(slid(stood, [0.0018, 0.0024, 0.0]))
    assert report.steps == 4 * (FRAMES - 1)
    assert report.simulated.mean_mm == pytest.approx(3.0)
    assert report.simulated.p95_mm == pytest.approx(3.0)
    assert report.simulated.max_mm == pytest.approx(3.0)
    assert report.asked.max_mm == pytest.approx(0.0, abs=1e-9)
    assert report.slide == pytest.approx(np.full((FRAMES - 1, 4), 0.003))


@pytest.mark.parametrize("height", [-0.03, 0.03, 0.06])
def test_a_displaced_clip_rests_all_the_same(stood, height):
    report = metrics.stance_slide(slid(stood, [0.001, 0.0, 0.0], standing(height)))
    assert report.steps == 4 * (FRAMES - 1)
    assert report.simulated.mean_mm == pytest.approx(1.0)


def test_a_foot_in_the_air_beside_one_that_stands_steps_and_does_not_slide(stood):
    result = slid(stood, [0.003, 0.0, 0.0])
    person = result.people[0]
    rotations = person.motion.rotations.copy()
    rotations[:, JOINT_INDEX["right_hip"], 0] = -0.5
    rotations[:, JOINT_INDEX["right_knee"], 0] = 0.8
    lifted = dataclasses.replace(
        person, motion=person.motion.with_frames(person.motion.translation, rotations)
    )
    report = metrics.stance_slide(dataclasses.replace(result, people=(lifted,)))
    assert report.steps == 2 * (FRAMES - 1)
    assert np.isnan(report.slide[:, 2:]).all()
    assert report.slide[:, :2] == pytest.approx(np.full((FRAMES - 1, 2), 0.003))


def test_feet_far_above_everything_do_not_rest(stood):
    report = metrics.stance_slide(slid(stood, [0.001, 0.0, 0.0], standing(0.2)))
    assert (report.steps, report.simulated.max_mm) == (0, 0.0)
    assert np.isnan(report.slide).all()


def test_a_moving_reference_is_no_stance(stood):
    fast = standing().translation + np.arange(FRAMES)[:, None] * [0.26 / 30.0, 0.0, 0.0]
    assert metrics.stance_slide(slid(stood, [0, 0, 0], t_pose(fast))).steps == 0


def test_what_stands_on_a_moving_box_is_measured_relative_to_it():
    """A box that slides and turns; the person goes along, or stays behind."""
    scene = Scene()
    scene.add_object("box", Box((2.0, 2.0, 0.2)), mass=50.0, position=(0.0, 0.0, 0.1))
    result = simulate(standing(0.002, 0.2), scene, settings=as_it_is())
    way = np.arange(FRAMES)[:, None] * [0.004, 0.0, 0.0]
    track = ObjectTrack(
        position=way + np.array([0.0, 0.0, 0.1]), quaternion=np.tile([1.0, 0, 0, 0], (FRAMES, 1))
    )
    result = dataclasses.replace(result, objects={"box": track})
    along = metrics.stance_slide(slid(result, [0.004, 0.0, 0.0]))
    assert along.steps > 0
    assert along.simulated.max_mm == pytest.approx(0.0, abs=1e-6)
    behind = metrics.stance_slide(slid(result, [0.0, 0.0, 0.0]))
    assert behind.simulated.mean_mm == pytest.approx(4.0, abs=1e-6)
    spin = rot.exp(np.arange(FRAMES)[:, None] * [0.0, 0.0, 0.01])
    turning = ObjectTrack(position=np.tile([0.0, 0, 0.1], (FRAMES, 1)), quaternion=spin)
    turned = metrics.stance_slide(dataclasses.replace(result, objects={"box": turning}))
    assert turned.simulated.mean_mm > 0.5  # feet beside the axis


def test_the_patches_of_the_soles():
    body = Body.default()
    patch, rest = sole_patches(body), body.rest_vertices
    assert set(patch) == {-1, 0, 1, 2, 3}
    for k, name in enumerate(PATCHES):
        its = rest[patch == k]
        foot = body.rest_joints[JOINT_INDEX[f"{name.split('_')[0]}_ankle"]]
        assert np.ptp(its[:, 1]) <= 0.015
        assert (np.sign(its[:, 0]) == np.sign(foot[0])).all()
        front = its[:, 2].mean() > foot[2]
        assert front == name.endswith("toe")


def test_slow_low_and_not_airborne():
    """Patches at 0.02, 0.04 and 0.2 m of which one moves; gaps as if on a step of 0.1 m."""
    centres = np.zeros((5, 4, 3))
    centres[:, 1, 0] = np.arange(5) * 0.01  # 0.3 m/s
    lowest = np.tile([0.02, 0.02, 0.04, 0.2], (5, 1))
    rests = in_stance(centres, lowest, lowest, np.zeros(5, dtype=bool), 30.0)
    assert rests.all(axis=0).tolist() == [True, False, True, False]
    on_step = in_stance(centres, lowest, lowest - [0, 0, 0, 0.2], np.zeros(5, dtype=bool), 30.0)
    assert on_step.all(axis=0).tolist() == [True, False, True, True]
    assert not in_stance(centres, lowest, lowest, np.ones(5, dtype=bool), 30.0).any()
