"""Arguments of measures that cannot be measured are refused in words."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.kimodo import foot_contacts

JOINTS = np.zeros((6, 22, 3))
FEET = {
    "gmd_skating_ratio": lambda joints: metrics.gmd_skating_ratio(joints, 20.0),
    "foot_sliding_mm": metrics.foot_sliding_mm,
    "foot_skate_ratio": lambda joints: metrics.foot_skate_ratio(joints, 20.0),
    "foot_skate_from_height": lambda joints: metrics.foot_skate_from_height(joints, 20.0),
    "foot_contacts": lambda joints: foot_contacts(joints, 20.0),
}
ANY = FEET | {
    "jitter": lambda joints: metrics.jitter(joints, 20.0),
    "acceleration_error": lambda joints: metrics.acceleration_error(joints, joints, 20.0),
    "phc_success": lambda joints: metrics.phc_success(joints, joints),
}


@pytest.mark.parametrize("name", ANY)
def test_positions_have_frames_joints_and_coordinates(name):
    ANY[name](JOINTS)
    for wrong in (JOINTS[0], JOINTS[..., :2], JOINTS[None], np.zeros(())):
        with pytest.raises(InputError, match=r"joints: found shape \(.*\), expected \(T, J, 3\)"):
            ANY[name](wrong)
    for few in (JOINTS[:0], JOINTS[:, :0]):
        with pytest.raises(InputError, match=r"joints: found . frames of .* expected at least"):
            ANY[name](few)


@pytest.mark.parametrize("name", FEET)
def test_feet_are_among_the_joints(name):
    FEET[name](JOINTS[:, :12])
    with pytest.raises(InputError, match="6 frames of 11 joints, expected at least 2 of 12"):
        FEET[name](JOINTS[:, :11])
    with pytest.raises(InputError, match="1 frames of 22 joints, expected at least 2 of 12"):
        FEET[name](JOINTS[:1])


@pytest.mark.parametrize("name", sorted(set(ANY) - {"phc_success"}))
def test_numbers_that_are_none_are_refused(name):
    lost = JOINTS.copy()
    lost[3, 10] = np.nan
    with pytest.raises(InputError, match="joints: found 3 numbers that are not finite"):
        ANY[name](lost)
    assert not metrics.phc_success(lost, JOINTS)  # what is lost is far from all


def test_scores_are_of_at_least_one_label():
    with pytest.raises(InputError, match="contact: found no labels"):
        metrics.contact_scores([], [])
