"""Scenes put elsewhere are the same scenes, and a jamb stops people alike there."""

from __future__ import annotations

import numpy as np
import pytest

from campaigns.invariance import (
    FIRST,
    MIRRORED,
    PLACES,
    WHOLE,
    cases,
    differences,
    joints,
    put_motion,
)
from halfphysics.body.body import Body


@pytest.fixture(scope="module")
def body():
    return Body.default()


@pytest.mark.parametrize("name", PLACES)
def test_the_motion_put_elsewhere_is_the_motion_seen_from_there(body, name):
    place = PLACES[name]
    (_, case), *_ = cases("skin")
    there = body.joints(put_motion(case.motion, place, body)) - place.shift - place.beside
    seen = there @ place.matrix
    seen = seen[:, MIRRORED] if place.mirror else seen
    # Coordinates of 100 m are rounded to 1.4e-14 m.
    np.testing.assert_allclose(seen, body.joints(case.motion), atol=1e-12)


def test_a_jamb_stops_people_alike_wherever_it_is(body):
    case = dict(cases("skin"))["jamb"]
    assert joints(case, PLACES["yaw"], body)[1] < len(case.motion) - 1  # it is touched
    for name, (second, whole) in differences(case, body).items():
        assert second <= FIRST, name
        assert whole <= WHOLE, name
