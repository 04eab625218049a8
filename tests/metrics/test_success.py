"""Success: every frame finite, at the requested rate."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.errors import InputError
from support.point_bodies import Drift


def _clip(frames: int, fps: float = 30.0) -> Drift:
    return Drift(np.zeros((frames, 3)), fps)


def test_success_is_every_frame_finite_at_the_rate_asked() -> None:
    asked = _clip(9)
    assert metrics.success(_clip(9), asked)
    assert not metrics.success(None, asked)
    assert not metrics.success(_clip(8), asked)
    assert not metrics.success(_clip(9, 60.0), asked)
    for wrong in (np.nan, np.inf):
        broken = _clip(9)
        broken.translation[4, 1] = wrong
        assert not metrics.success(broken, asked)
    with pytest.raises(InputError, match=r"asked: expected a halfphysics\.Motion"):
        metrics.success(_clip(9), None)
    with pytest.raises(InputError, match=r"motion: expected a halfphysics\.Motion"):
        metrics.success(3, asked)


def test_phc_fails_in_one_frame_over_half_a_metre() -> None:
    truth = np.random.default_rng(0).normal(size=(6, 22, 3))
    assert metrics.phc_success(
        truth + np.array([0.0, 0.2999, 0.4]), truth
    )  # under 0.5 m in every frame
    far = truth.copy()
    far[3, :11] += [1.01, 0.0, 0.0]  # half of the joints by 1.01 m: 0.505 m on average
    assert not metrics.phc_success(far, truth)
    far[3, :11] -= [0.02, 0.0, 0.0]
    assert metrics.phc_success(far, truth)


def test_the_truth_of_phc_has_the_same_joints() -> None:
    """A truth of one frame was that of all; joints that are no numbers are near none."""
    joints = np.zeros((4, 22, 3))
    for truth in (joints[:1], joints[:, :5], joints + np.nan):
        with pytest.raises(InputError, match="truth: found"):
            metrics.phc_success(joints, truth)
    assert not metrics.phc_success(joints + np.nan, joints)
