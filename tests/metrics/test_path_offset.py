"""Offset and tilt from the path: known turns and shifts."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Plane
from halfphysics.scene.scene import Scene
from halfphysics.simulation.simulate import simulate
from support.people import t_pose

FRAMES = 6


@pytest.fixture(scope="module")
def quiet():
    scene = Scene()
    scene.add_static("floor", Plane(offset=-3.0))
    return simulate(t_pose(np.zeros((FRAMES, 3))), scene)


def moved(result, shift, turn):
    """The result with the person moved by `shift` and turned by the world's `turn` (rotvec)."""
    person = result.people[0]
    rotations = person.reference.rotations.copy()
    rotations[:, 0] = rot.log(rot.multiply(rot.exp(turn), rot.exp(rotations[:, 0])))
    motion = person.reference.with_frames(person.reference.translation + shift, rotations)
    return dataclasses.replace(result, people=(dataclasses.replace(person, motion=motion),))


def test_a_static_tilt_of_two_degrees(quiet):
    report = metrics.path_offset(moved(quiet, [0.3, 0.4, -0.05], np.deg2rad([0.0, 2.0, 0.0])))
    assert report.end_tilt_deg == pytest.approx(2.0)
    assert report.tilt == pytest.approx(np.full(FRAMES, np.deg2rad(2.0)))
    assert report.end_heading_deg == pytest.approx(0.0, abs=1e-9)
    assert report.end_offset_mm == pytest.approx(500.0)
    assert report.end_height_mm == pytest.approx(-50.0)
    assert report.max_height_mm == pytest.approx(50.0)


def test_followed_exactly_is_zero(quiet):
    report = metrics.path_offset(quiet)
    assert report.max_offset_mm < 1e-6
    assert report.max_tilt_deg < 1e-6
    assert not report.offset.flags.writeable


def test_over_time(quiet):
    shift = np.zeros((FRAMES, 3))
    shift[:, 0] = [0.0, 0.1, 0.3, 0.2, 0.1, 0.05]
    report = metrics.path_offset(moved(quiet, shift, np.zeros(3)))
    assert report.offset == pytest.approx(shift[:, 0])
    assert report.max_offset_mm == pytest.approx(300.0)
    assert report.end_offset_mm == pytest.approx(50.0)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.1, 3.1))
def test_tilt_and_heading_come_apart(quiet, tilt, axis, heading):
    lean = rot.exp(tilt * np.array([np.cos(axis), np.sin(axis), 0.0]))
    turn = rot.log(rot.multiply(rot.exp([0.0, 0.0, heading]), lean))
    report = metrics.path_offset(moved(quiet, np.zeros(3), turn))
    assert report.end_tilt_deg == pytest.approx(np.rad2deg(tilt), abs=1e-6)
    assert report.end_heading_deg == pytest.approx(np.rad2deg(heading), abs=1e-6)
    up = rot.rotate(rot.exp(turn), [0.0, 0.0, 1.0])
    assert up[2] == pytest.approx(np.cos(np.deg2rad(report.end_tilt_deg)), abs=1e-9)
