"""Foot skate, by hand and by closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.motion.skeleton import JOINT_INDEX
from support.point_bodies import Cloud, Drift

FEET = [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]


class Puppet:
    """A body with given joints (T, 55, 3)."""

    def __init__(self, joints: np.ndarray) -> None:
        self.given = joints

    def joints(self, motion: Any) -> np.ndarray:
        return self.given


def _clip(frames: int, fps: float = 30.0) -> Drift:
    return Drift(np.zeros((frames, 3)), fps)


def _feet(steps: list[tuple[float, float]], heights: list[tuple[float, float]]) -> Puppet:
    """Feet with these steps [m] along x from frame to frame, at these heights [m]."""
    joints = np.full((len(heights), 55, 3), 1.0)
    joints[:, FEET, 0] = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    joints[:, FEET, 2] = heights
    return Puppet(joints)


def test_foot_skate_by_hand() -> None:
    """Four steps at 20 fps: slide of 30 mm, of 10 mm, one in the air, both feet slide."""
    low, high = 0.03, 0.2
    puppet = _feet(
        [(0.03, 0.0), (0.0, 0.01), (0.5, 0.0), (0.04, 0.05)],
        [(low, low), (low, low), (high, low), (low, low), (low, low)],
    )
    report = metrics.foot_skate(_clip(5, 20.0), puppet)
    # The left foot is down in steps 1 and 4 (in 2 and 3 it is up at one end), the right in all.
    assert report.steps == 6
    assert report.mean_mm == pytest.approx((30 + 40 + 0 + 10 + 0 + 50) / 6)
    assert report.mean_speed == pytest.approx(0.02 * report.mean_mm)
    assert report.share_percent == pytest.approx(50.0)  # steps 1 and 4: over 25 mm a frame
    slow = metrics.foot_skate(_clip(5, 20.0), puppet, speed=0.1)
    assert slow.share_percent == pytest.approx(75.0)
    sunk = metrics.foot_skate(_clip(5, 20.0), puppet, ground=-0.05)
    assert (sunk.steps, sunk.mean_mm, sunk.share_percent) == (0, 0.0, 0.0)


@given(st.floats(0.0, 3.0), st.sampled_from([20.0, 60.0]), st.floats(-1.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_a_body_that_glides_skates_at_its_speed(speed: float, fps: float, ground: float) -> None:
    path = np.arange(6)[:, None] * [0.6 * speed / fps, 0.8 * speed / fps, 0.0] + [0, 0, ground]
    report = metrics.foot_skate(Drift(path, fps), Cloud(np.zeros((55, 3))), ground=ground)
    assert report.mean_speed == pytest.approx(speed, abs=1e-12)
    # Of the five steps the outer ones have only three or four of the window's five in the clip.
    means = [speed * count / 5.0 for count in (3, 4, 5, 4, 3)]
    if all(abs(mean - 0.5) > 1e-9 for mean in means):
        assert report.share_percent == pytest.approx(20.0 * sum(mean > 0.5 for mean in means))


@pytest.mark.parametrize(
    "wrong", [{"height": 0.0}, {"speed": -1.0}, {"ground": np.nan}, {"height": "5 cm"}], ids=str
)
def test_impossible_limits_of_skating(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        metrics.foot_skate(_clip(5), Puppet(np.zeros((5, 55, 3))), **wrong)
