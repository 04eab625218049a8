"""Shifts between rests: they come and go in the air, and rests keep theirs."""

from __future__ import annotations

import numpy as np

from halfphysics.repair.swings import SWING, over_swings, runs

FPS = 30.0


def test_runs_are_where_a_mask_is_true():
    assert runs(np.array([1, 1, 0, 1, 0, 0, 1], dtype=bool)) == [(0, 2), (3, 4), (6, 7)]
    assert runs(np.zeros(4, dtype=bool)) == []


def test_a_long_swing_comes_back_to_the_way_as_it_was():
    stands = np.ones(80, dtype=bool)
    stands[10:60] = False
    shift = np.full((80, 3), 99.0)
    shift[:10], shift[60:] = [0.02, 0.0, 0.0], [0.0, -0.03, 0.01]
    made = over_swings(shift, stands, FPS)
    assert np.array_equal(made[stands], shift[stands])
    away = round(SWING * FPS)
    assert np.abs(made[10 + away : 60 - away]).max() < 1e-15
    # It eases: no step is more than twice that of a straight line.
    assert np.abs(np.diff(made, axis=0)).max() < 2.0 * 0.03 / away


def test_a_short_swing_goes_from_one_shift_to_the_next():
    stands = np.ones(20, dtype=bool)
    stands[8:12] = False
    shift = np.zeros((20, 3))
    shift[:8], shift[12:] = 0.02, 0.04
    made = over_swings(shift, stands, FPS)
    assert (np.diff(made[:, 0]) > -1e-15).all()
    assert made[8:12].min() >= 0.02 - 1e-15
    assert made.max() <= 0.04 + 1e-15


def test_before_the_first_rest_and_after_the_last_there_is_no_shift():
    stands = np.zeros(60, dtype=bool)
    stands[25:35] = True
    made = over_swings(np.where(stands[:, None], 0.01, 0.0) * np.ones(3), stands, FPS)
    assert not made[0].any()
    assert not made[-1].any()
