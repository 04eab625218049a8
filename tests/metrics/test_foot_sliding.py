"""GMD's skating ratio and FS, by loops over frames that share nothing with the code."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics

EXACT = 1e-9


def feet(seed: int, frames: int) -> np.ndarray:
    """22 joints whose feet hover about the limits of height and speed."""
    rng = np.random.default_rng(seed)
    joints = rng.normal(size=(frames, 22, 3))
    steps = rng.normal(scale=0.03, size=(frames, 22, 2))
    joints[..., :2] = np.cumsum(steps, axis=0)
    joints[..., 2] = rng.uniform(-0.02, 0.1, size=(frames, 22))
    return joints


def ratio_by_hand(joints: np.ndarray, fps: float, ground: float) -> float:
    steps = len(joints) - 1
    speeds = {
        foot: [fps * math.dist(joints[t, foot, :2], joints[t + 1, foot, :2]) for t in range(steps)]
        for foot in (10, 11)
    }
    count = 0
    for t in range(steps):
        skates = False
        for foot, own in speeds.items():
            low = all(joints[k, foot, 2] - ground < 0.05 for k in (t, t + 1))
            mean = sum(own[k] for k in range(t - 2, t + 3) if 0 <= k < steps) / 5.0
            skates = skates or (low and own[t] > 0.5 and mean > 0.5)
        count += skates
    return count / steps


@given(st.integers(0, 10**6), st.integers(2, 30), st.sampled_from([20.0, 30.0]))
@settings(max_examples=30, deadline=None)
def test_the_ratio_is_that_of_the_definition(seed: int, frames: int, fps: float) -> None:
    joints = feet(seed, frames)
    for ground in (0.0, 0.03):
        found = metrics.gmd_skating_ratio(joints, fps, ground=ground)
        assert found == pytest.approx(ratio_by_hand(joints, fps, ground), abs=EXACT)


def test_a_single_fast_step_is_no_skating() -> None:
    """The filter of GMD's code: a jump of 10 cm in one step of 20 fps is 0.4 m/s over five."""
    joints = np.zeros((12, 22, 3))
    joints[6:, 10, 0] = 0.1
    assert metrics.gmd_skating_ratio(joints, 20.0) == 0.0
    joints[6:, 10, 0] = 0.13  # 2.6 m/s, 0.52 over five
    assert metrics.gmd_skating_ratio(joints, 20.0) == pytest.approx(1 / 11)


def sliding_by_hand(joints: np.ndarray, ground: float) -> float:
    each = []
    for joint, limit in ((7, 0.08), (10, 0.04), (8, 0.08), (11, 0.04)):
        total = 0.0
        for t in range(len(joints) - 1):
            h = joints[t, joint, 2] - ground
            if h < limit:
                step = math.dist(joints[t, joint, :2], joints[t + 1, joint, :2])
                total += step * (2.0 - 2.0 ** (h / limit))
        each.append(1000.0 * total / len(joints))
    return sum(each) / 4.0


@given(st.integers(0, 10**6), st.integers(2, 30))
@settings(max_examples=30, deadline=None)
def test_fs_is_that_of_the_definition(seed: int, frames: int) -> None:
    joints = feet(seed, frames)
    for ground in (0.0, -0.02):
        found = metrics.foot_sliding_mm(joints, ground=ground)
        assert found == pytest.approx(sliding_by_hand(joints, ground), abs=EXACT)


def test_fs_of_one_toe_on_the_ground() -> None:
    """Ten steps of 4 mm at height 0 weigh 1 each: 40 mm over 11 frames, a quarter of it."""
    joints = np.full((11, 22, 3), 1.0)
    joints[:, 11] = 0.0
    joints[:, 11, 1] = 0.004 * np.arange(11)
    assert metrics.foot_sliding_mm(joints) == pytest.approx(40.0 / 11 / 4, abs=EXACT)
