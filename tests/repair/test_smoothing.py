"""A low pass without a phase: slow motion stays, jitter goes, nothing is late."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.errors import InputError
from halfphysics.repair.smoothing import low_passed

FPS = 60.0


def swung(frequency, seconds=6.0):
    t = np.arange(round(seconds * FPS)) / FPS
    wave = np.sin(2.0 * np.pi * frequency * t)
    turns = np.zeros((len(t), 55, 3))
    turns[:, 16, 1] = 0.5 * wave
    return hp.Motion(np.outer(0.1 * wave, [1.0, 0.0, 0.0]), turns, FPS)


def gain(frequency, cutoff=6.0):
    """Of translation and of a joint's angle: size after, over size before, away from the ends."""
    asked = swung(frequency)
    made = low_passed(asked, cutoff)
    middle = slice(90, -90)
    return [
        float((after[middle] @ before[middle]) / (before[middle] @ before[middle]))
        for before, after in (
            (asked.translation[:, 0], made.translation[:, 0]),
            (asked.rotations[:, 16, 1], made.rotations[:, 16, 1]),
        )
    ]


def test_gain_is_that_of_two_passes_of_a_second_order_butterworth():
    # 1 / (1 + (tan(pi f / fps) / tan(pi fc / fps))^4): both passes, after the bilinear transform.
    for frequency in (0.5, 3.0, 6.0, 15.0):
        warped = np.tan(np.pi * frequency / FPS) / np.tan(np.pi * 6.0 / FPS)
        for found in gain(frequency):
            assert abs(found - 1.0 / (1.0 + warped**4)) < 0.02


def test_joints_that_never_move_keep_their_bits():
    asked = swung(1.0)
    rotations = np.array(asked.rotations)
    rotations[:, 3] = [0.1, 0.2, 0.3]
    made = low_passed(asked.with_frames(asked.translation, rotations), 6.0)
    assert np.array_equal(made.rotations[:, 3], rotations[:, 3])


def test_half_the_frame_rate_and_more_changes_nothing():
    asked = swung(2.0)
    for cutoff in (0.5 * FPS, 2.0 * FPS):
        assert low_passed(asked, cutoff) is asked


def test_a_cutoff_is_positive():
    with pytest.raises(InputError, match="smooth"):
        low_passed(swung(1.0), 0.0)
