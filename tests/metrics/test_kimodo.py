"""Kimodo's four, by loops over frames and feet."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.kimodo import foot_contacts

EXACT = 1e-9
ORDER = (7, 10, 8, 11)


def feet(seed: int, frames: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    joints = np.cumsum(rng.normal(scale=0.004, size=(frames, 22, 3)), axis=0)
    joints[..., 2] = rng.uniform(0.0, 0.12, size=(1, 22)) + 0.1 * joints[..., 2]
    return joints


def speed(joints: np.ndarray, t: int, joint: int, fps: float) -> float:
    return fps * math.dist(joints[t, joint], joints[t + 1, joint])


cases = given(st.integers(0, 10**6), st.integers(2, 25), st.sampled_from([20.0, 30.0]))


@cases
@settings(max_examples=25, deadline=None)
def test_from_height_and_ratio(seed: int, frames: int, fps: float) -> None:
    joints = feet(seed, frames)
    pairs = [(t, j) for t in range(frames - 1) for j in (10, 11)]
    begins = [speed(joints, t, j, fps) for t, j in pairs if joints[t, j, 2] < 0.05]
    both = [
        speed(joints, t, j, fps)
        for t, j in pairs
        if joints[t, j, 2] < 0.05 and joints[t + 1, j, 2] < 0.05
    ]
    mean, ratio = sum(begins) / (len(begins) + 1e-6), sum(v > 0.2 for v in both)
    assert metrics.foot_skate_from_height(joints, fps) == pytest.approx(mean, abs=EXACT)
    assert metrics.foot_skate_ratio(joints, fps) == pytest.approx(
        ratio / (len(both) + 1e-6), abs=EXACT
    )
    lifted = joints + np.array([0.0, 0.0, 0.3])
    assert metrics.foot_skate_from_height(lifted, fps, ground=0.3) == pytest.approx(mean, abs=1e-6)


@cases
@settings(max_examples=25, deadline=None)
def test_from_contacts_and_consistency(seed: int, frames: int, fps: float) -> None:
    joints = feet(seed, frames)
    labels = np.random.default_rng(seed).random((frames, 4)) < 0.5
    places = [(t, k) for t in range(frames - 1) for k in range(4)]
    held = [speed(joints, t, ORDER[k], fps) for t, k in places if labels[t, k]]
    assert metrics.foot_skate_from_contacts(joints, fps, labels) == pytest.approx(
        sum(held) / (len(held) + 1e-6), abs=EXACT
    )
    told = [
        joints[t, ORDER[k], 2] < 0.1 and speed(joints, t, ORDER[k], fps) < 0.15 for t, k in places
    ]
    agree = sum(said == labels[t, k] for said, (t, k) in zip(told, places, strict=True))
    assert metrics.foot_contact_consistency(joints, fps, labels) == pytest.approx(
        agree / len(places), abs=EXACT
    )
    assert metrics.foot_contact_consistency(joints, fps, foot_contacts(joints, fps)) == 1.0


def test_without_contact_nothing_skates() -> None:
    joints = np.random.default_rng(0).normal(size=(9, 22, 3)) + np.array([0.0, 0.0, 50.0])
    assert metrics.foot_skate_from_height(joints, 30.0) == 0.0
    assert metrics.foot_skate_ratio(joints, 30.0) == 0.0
    assert metrics.foot_skate_from_contacts(joints, 30.0, np.zeros((9, 4), dtype=bool)) == 0.0


@pytest.mark.parametrize("contacts", [np.ones((2, 4)), np.ones((6, 2)), np.full((6, 4), np.nan)])
def test_labels_are_of_the_joints_frames(contacts: np.ndarray) -> None:
    """Two labels were one for all steps."""
    joints = np.zeros((6, 22, 3))
    for measure in (metrics.foot_skate_from_contacts, metrics.foot_contact_consistency):
        with pytest.raises(InputError, match="contacts: found"):
            measure(joints, 30.0, contacts)
        with pytest.raises(InputError, match="joints: found 396 numbers that are not finite"):
            measure(joints + np.nan, 30.0, np.ones((6, 4)))
