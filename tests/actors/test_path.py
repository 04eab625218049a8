"""Ways over the floor."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from halfphysics.actors.path import Path, Point

CORNER = Path([Point(0.0, 0.0), Point(0.0, 0.0), Point(2.0, 0.0), Point(2.0, 1.0)])


def test_places_and_headings_by_distance():
    assert CORNER.length == 3.0
    assert CORNER.at(0.5) == (0.5, 0.0)
    assert CORNER.at(2.5) == (2.0, 0.5)
    assert CORNER.at(9.0) == CORNER.end == (2.0, 1.0)
    assert CORNER.heading(1.0) == 0.0
    assert CORNER.heading(2.5) == pytest.approx(math.pi / 2)
    assert Path([Point(1.0, 1.0)]).heading(0.0) is None


def test_the_nearest_place():
    assert CORNER.nearest(0.5, 3.0) == pytest.approx(0.5) or CORNER.nearest(0.5, 3.0) == 3.0
    assert CORNER.nearest(1.2, -1.0) == pytest.approx(1.2)
    assert CORNER.nearest(5.0, 0.7) == pytest.approx(2.7)


def test_rounded_corners_stay_near():
    soft = CORNER.rounded(0.3)
    assert soft.at(0.0) == CORNER.at(0.0)
    assert soft.end == CORNER.end
    assert CORNER.length - 0.3 < soft.length < CORNER.length
    turns = [soft.heading(0.01 * k) for k in range(int(soft.length / 0.01))]
    assert max(abs(b - a) for a, b in pairwise(turns)) < 0.5
