"""Jerk, by closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.errors import InputError
from support.point_bodies import Cloud, Drift


class Puppet:
    """A body with given joints (T, 55, 3)."""

    def __init__(self, joints: np.ndarray) -> None:
        self.given = joints

    def joints(self, motion: Any) -> np.ndarray:
        return self.given


def _clip(frames: int, fps: float = 30.0) -> Drift:
    return Drift(np.zeros((frames, 3)), fps)


@given(
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
    st.sampled_from([20.0, 30.0, 120.0]),
    st.integers(4, 40),
)
@settings(max_examples=30, deadline=None)
def test_jerk_of_cubics_is_exact(third: list[float], fps: float, frames: int) -> None:
    """x = a t^3 / 6 + 0.4 t^2 - t + 1 has jerk |a| at every rate."""
    t = np.arange(frames)[:, None] / fps
    path = np.array(third) * t**3 / 6.0 + 0.4 * t**2 - t + 1.0
    found = metrics.jerk(Drift(path, fps), Cloud(np.zeros((55, 3))))
    # Rounding of positions of about 1 m, times fps^3.
    assert found == pytest.approx(float(np.linalg.norm(third)), abs=1e-14 * fps**3, rel=1e-9)


def test_jerk_is_the_mean_over_joints() -> None:
    joints = np.zeros((5, 55, 3))
    joints[:, 7, 0] = np.arange(5) ** 3  # third difference 6
    assert metrics.jerk(_clip(5, 10.0), Puppet(joints)) == pytest.approx(6.0 * 1000.0 / 55)
    with pytest.raises(InputError, match="jerk takes at least 4 frames, found 3"):
        metrics.jerk(_clip(3), Puppet(joints[:3]))
    with pytest.raises(InputError, match="body: expected"):
        metrics.jerk(_clip(5), None)


def _joints(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(9, 22, 3))


@pytest.mark.parametrize("fps", [20.0, 30.0])
def test_jitter_by_hand(fps: float) -> None:
    x, sizes = _joints(0), []
    for t in range(6):
        for j in range(22):
            third = x[t + 3, j] - 3 * x[t + 2, j] + 3 * x[t + 1, j] - x[t, j]
            sizes.append(float(np.sqrt((third**2).sum())) * fps**3)
    assert metrics.jitter(x, fps) == pytest.approx(sum(sizes) / len(sizes) / 10.0, rel=1e-12)


@pytest.mark.parametrize("fps", [20.0, 30.0])
def test_acceleration_error_by_hand(fps: float) -> None:
    x, y, errors = _joints(1), _joints(2), []
    for t in range(1, 8):
        for j in range(22):
            own, true = (
                [p[k, j] - 0.5 * (p[k, 1] + p[k, 2]) for k in (t - 1, t, t + 1)] for p in (x, y)
            )
            difference = (own[0] - 2 * own[1] + own[2]) - (true[0] - 2 * true[1] + true[2])
            errors.append(float(np.sqrt((difference**2).sum())) * fps**2)
    found = metrics.acceleration_error(x, y, fps)
    assert found == pytest.approx(sum(errors) / len(errors), rel=1e-12)
    # A motion of the whole has no error relative to the hips.
    moved = x + np.cumsum(np.ones((9, 1, 3)), axis=0) ** 3
    assert metrics.acceleration_error(moved, x, fps) == pytest.approx(0.0, abs=1e-8)


def test_the_truth_of_accelerations_has_the_same_joints() -> None:
    """Three frames, which have one acceleration, were the truth of all."""
    joints = np.random.default_rng(0).normal(size=(9, 22, 3))
    for truth in (joints[:3], joints[:, :5], joints + np.nan):
        with pytest.raises(InputError, match="truth: found"):
            metrics.acceleration_error(joints, truth, 30.0)
