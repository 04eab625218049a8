"""The usual time between two poses of a sender."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.live.clock import MOST
from halfphysics.live.interval import Interval

PERIOD = 1.0 / 90.0


def intervals(arrivals):
    """Interval over the period after each arrival but the first."""
    interval, found = Interval(), []
    for gap in np.diff(arrivals):
        interval.add(float(gap))
        found.append(interval.seconds / PERIOD)
    return np.array(found)


def test_it_is_unknown_until_two_poses_have_come():
    interval = Interval()
    assert interval.seconds == 0.0
    interval.add(0.02)
    assert interval.seconds == 0.02
    interval.clear()
    assert interval.seconds == 0.0


@pytest.mark.parametrize("every", [4, 10, 50])
def test_lost_poses_do_not_change_it(every):
    sent = PERIOD * np.arange(400)
    found = intervals(sent[np.arange(400) % every != every - 1])
    assert found == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(("many", "off"), [(2, 1.0 / 64.0), (3, 0.3)])
def test_poses_that_come_together_are_counted_one_by_one(many, off):
    """Exactly of pairs; nearly of three, whose period is told by the first few gaps."""
    sent = PERIOD * many * (np.arange(400) // many) + 1e-4 * (np.arange(400) % many)
    assert intervals(sent)[80:] == pytest.approx(1.0, abs=off)


@pytest.mark.parametrize("jitter", [0.001, 0.004, 0.008])
def test_jitter_changes_it_by_less_than_the_clock_makes_up_for(jitter):
    rng = np.random.default_rng(0)
    found = intervals(np.sort(PERIOD * np.arange(4000) + jitter * rng.random(4000)))
    assert np.abs(found[64:] - 1.0).max() < MOST


@pytest.mark.parametrize("factor", [1 / 3, 1 / 2, 2, 3])
def test_another_rate_is_known_after_four_poses(factor):
    gaps = np.repeat([PERIOD / factor, PERIOD], [100, 4])
    assert intervals(np.cumsum(np.concatenate([[0.0], gaps])))[-1] == pytest.approx(1.0, abs=1e-9)


def test_a_rate_that_is_nearly_the_same_is_known_after_all_gaps_that_count():
    gaps = np.repeat([PERIOD * 1.25, PERIOD], [100, 65])
    assert intervals(np.cumsum(gaps))[-1] == pytest.approx(1.0, abs=1e-9)


def test_poses_of_one_moment_are_no_interval():
    interval = Interval()
    for _ in range(40):
        interval.add(0.0)
    assert interval.seconds == 0.0
