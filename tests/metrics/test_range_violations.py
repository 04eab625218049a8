"""Range violations: knees that bend the wrong way, and references that ask for it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.body.body import Body
from halfphysics.body.joint_ranges import JointRanges
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.people import t_pose

FRAMES, KNEE = 8, JOINT_INDEX["left_knee"]
RANGES = JointRanges.of(Body.default())
#: The knee's axis of flexion, and its least flexion [rad].
AXIS, LEAST = RANGES.axes[KNEE, 1], RANGES.lower[KNEE, 1]


@pytest.fixture(scope="module")
def quiet():
    return simulate(t_pose(np.zeros((FRAMES, 3))), Scene())


def bent(result, angles, asked=None):
    """The left knee bent by angles (T,) [rad] in the result, and by `asked` in the reference."""
    person, motions = result.people[0], []
    for own in (angles, np.zeros(FRAMES) if asked is None else asked):
        rotations = person.reference.rotations.copy()
        rotations[:, KNEE] = np.asarray(own)[:, None] * AXIS
        motions.append(person.reference.with_frames(person.reference.translation, rotations))
    person = dataclasses.replace(person, motion=motions[0], reference=motions[1])
    return dataclasses.replace(result, people=(person,))


def test_a_knee_that_bends_forwards(quiet):
    angles = np.zeros(FRAMES)
    angles[3] = LEAST - np.deg2rad(5.0)
    angles[5] = LEAST - np.deg2rad(1.0)
    report = metrics.range_violations(bent(quiet, angles))
    assert report.max_deg == pytest.approx(5.0)
    assert (report.joint, report.frame) == ("left_knee", 3)
    assert report.percent == pytest.approx(100.0 / FRAMES)
    assert report.beyond[5, KNEE] == pytest.approx(1.0)
    assert report.asked_deg == 0.0


def test_what_the_reference_asks_is_allowed(quiet):
    asked = np.full(FRAMES, LEAST - np.deg2rad(5.0))
    report = metrics.range_violations(bent(quiet, asked, asked))
    assert (report.max_deg, report.percent) == (0.0, 0.0)
    assert (report.joint, report.frame) == ("", -1)
    assert report.asked_deg == pytest.approx(5.0)
    beyond = metrics.range_violations(bent(quiet, asked - np.deg2rad(3.0), asked))
    assert beyond.max_deg == pytest.approx(3.0)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-1.0, 2.5), min_size=FRAMES, max_size=FRAMES))
def test_any_bend_by_its_range(quiet, angles):
    angles = np.array(angles)
    over = np.maximum(LEAST - angles, angles - RANGES.upper[KNEE, 1])
    report = metrics.range_violations(bent(quiet, angles))
    assert report.max_deg == pytest.approx(max(np.rad2deg(over.max()), 0.0), abs=1e-6)


def test_the_default_pose_is_within(quiet):
    assert metrics.range_violations(quiet).max_deg == 0.0
    with pytest.raises(InputError, match="person"):
        metrics.range_violations(quiet, 1)
