"""Contact labels of every scenario against geometry, judged by other libraries.

It checks a few vertices of each; `campaigns/labels.py` checks many, and measures.
"""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.labels import contact_labels
from support.judges.labels_judge import ROUNDING, judge

pytestmark = pytest.mark.slow

#: Last frames of the long ones here: all contacts occur before.
END = {
    "climb_onto_bed": 100,
    "fly_with_ball": 80,
    "grasp_glass": 110,
    "lift_suitcase": 100,
    "meet": 80,
    "place_glass": 110,
    "shake_hands": 110,
}
#: Scenarios in which nobody touches anything.
UNTOUCHED = ("reach_past_monitor", "ball_on_cushion")


@pytest.mark.slow
@pytest.mark.parametrize("name", hp.scenarios.names())
def test_labels_agree_with_geometry_and_no_impulse_is_without(name):
    told = hp.scenarios.load(name)
    motions, bodies = [motion[: END.get(name)] for motion in told.motions], list(told.bodies)
    result = hp.simulate(motions, told.scene, body=bodies, settings=told.settings)
    labels = contact_labels(result)
    verdict = judge(result, labels, most=15)
    if name not in UNTOUCHED:
        assert verdict.impulses > 0
        assert verdict.vertices + verdict.points + (len(result.people) > 1) > 0
    # The judge measures from the hard frames of what is soft.
    items = [*told.scene.statics.values(), *told.scene.objects.values()]
    layer = max((item.soft.thickness for item in items if item.soft), default=0.0)
    assert verdict.farthest <= layer + result.settings.clearance + 1e-3 + ROUNDING
    assert verdict.unlabelled == 0
    assert verdict.bare == 0
    assert np.isfinite(labels.contacts.distance).mean() > 0.5
