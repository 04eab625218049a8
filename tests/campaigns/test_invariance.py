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


#: Scenes with room to the limits: of the others one, where somebody is pressed evenly on left and
#: right, misses them, and in one what rounding leaves grows by a thousand in a second.
SCENES = (
    "jamb",
    "climb_onto_bed",
    "crawl_under_table",
    "leg_through_table",
    "sit_on_bed",
    "sit_on_sofa",
    "step_back_onto_cabinet",
    "stretch_on_bed",
)
#: Largest difference over the first second that was seen in them: 1.7e-7 m.
SECOND = 0.5 * FIRST


@pytest.mark.parametrize("name", SCENES)
def test_people_end_alike_wherever_it_is(body, name):
    """Beside by a nanometre, turned, 100 m away, and mirrored."""
    case = dict(cases("skin"))[name]
    assert joints(case, PLACES["yaw"], body)[1] < len(case.motion) - 1  # something is touched
    for place, (second, whole) in differences(case, body).items():
        assert second <= SECOND, place
        assert whole <= WHOLE, place
