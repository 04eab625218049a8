"""Motions that no person makes are refused by the class itself: speeds, degrees."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.motion.possible import MAX_SPEED, are_degrees
from support.files.layouts import movement


def test_a_root_faster_than_anybody_is_refused():
    places = np.zeros((5, 3))
    places[3:, 0] = 0.999 * MAX_SPEED / 30.0
    hp.Motion(places, np.zeros((5, 55, 3)), 30.0)
    places[3:, 0] = 1.001 * MAX_SPEED / 30.0
    with pytest.raises(InputError, match=r"m/s between frames 2 and 3 .30 fps.*cut"):
        hp.Motion(places, np.zeros((5, 55, 3)), 30.0)


def test_degrees_are_refused():
    """They were taken for radians: joints spun, and nothing said so."""
    translation, rotations = movement()
    with pytest.raises(InputError, match=r"rotations: .*expected axis-angle in radians.*degrees"):
        hp.Motion(translation, np.degrees(rotations), 30.0)
    hp.Motion(translation, rotations, 30.0)


def test_rotation_vectors_a_few_turns_too_long_are_none():
    translation, rotations = movement()
    length = np.linalg.norm(rotations, axis=2, keepdims=True)
    hp.Motion(translation, rotations * (1.0 + 6.0 * np.pi / length), 30.0)


@pytest.mark.parametrize("clip", ["kick_ball", "stretch_on_bed", "crawl_under_table"])
def test_scenarios_in_degrees_are_seen_and_in_radians_are_none(clip):
    rotations = hp.scenarios.load(clip).motion.rotations
    assert are_degrees(np.degrees(rotations))
    assert not are_degrees(rotations)


def test_who_turns_many_times_about_is_none():
    """The root of a spinning person, and three joints that nobody unwrapped."""
    translation, rotations = movement()
    rotations[:, 0] = [0.0, 0.0, 40.0]
    rotations[:, [5, 8, 12], 1] += 8.0 * np.pi
    rotations[:, 25:] = 25.0  # fingers may be noise
    hp.Motion(translation, rotations, 30.0)
