"""What hands that were asked to hold did."""

from __future__ import annotations

import numpy as np
import pytest

import halfphysics as hp
from halfphysics.adaptation.adapt import adapt
from halfphysics.adaptation.report import held


def test_forces_reached_and_margins(carry):
    """Each entry against the sums over its contacts, counted one by one."""
    made = adapt(carry.motion, carry.scene, carry.body, carry.recorded)
    result = hp.simulate(made.motion, carry.scene, body=carry.body)
    reports = held(result, made)
    assert [r.part for r in reports] == ["left_wrist", "right_wrist"]
    c, thing = result.contacts, result.names.index("suitcase")
    (hold,) = made.holds
    for report in reports:
        side = report.part.split("_")[0]
        sums = []
        for frame in range(hold.first, hold.last + 1):
            total = 0.0
            for i in np.flatnonzero((c.frame == frame) & (c.other == thing)):
                name = hp.JOINT_NAMES[c.part[i]]
                if name.startswith(side) and c.part[i] >= 20:
                    total += abs(float(c.impulse[i] @ c.normal[i])) * result.fps
            sums.append(total)
        assert report.reached == pytest.approx(float(np.median(sums)))
        assert report.asked == hold.force
        assert report.touched > 0.95
        assert report.margin > 1.0  # nothing slips
        assert 0.5 < report.reached / report.asked < 2.0


def test_hands_that_do_not_touch_report_nothing(carry):
    made = adapt(carry.motion, carry.scene, carry.body, carry.recorded)
    away = carry.motion.with_frames(
        carry.motion.translation + np.array([0.0, 0.0, 3.0]), carry.motion.rotations
    )
    result = hp.simulate(away, carry.scene, body=carry.body)
    for report in held(result, made):
        assert report.reached == 0.0
        assert report.touched == 0.0
        assert report.margin == 0.0
