"""Precision, recall, F1 and C%, by counting."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfphysics import metrics
from halfphysics.errors import InputError
from halfphysics.metrics.contact_scores import HANDS, hand_contact
from halfphysics.motion.skeleton import JOINT_NAMES


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=40))
def test_scores_are_counts(frames: list[tuple[bool, bool]]) -> None:
    scores = metrics.contact_scores([a for a, _ in frames], [b for _, b in frames])
    tp, fp, fn = (frames.count(pair) for pair in ((True, True), (True, False), (False, True)))
    assert scores.precision == pytest.approx(tp / (tp + fp) if tp + fp else 0.0, abs=1e-12)
    assert scores.recall == pytest.approx(tp / (tp + fn) if tp + fn else 0.0, abs=1e-12)
    # The same harmonic mean, by counts.
    assert scores.f1 == pytest.approx(2 * tp / (2 * tp + fp + fn) if tp else 0.0, abs=1e-12)
    assert scores.percent == pytest.approx(100.0 * (tp + fp) / len(frames), abs=1e-12)


def test_either_hand_touches_below_5_cm() -> None:
    distance = np.array([[0.06, 0.06], [0.049, 1.0], [1.0, -0.02], [0.05, 0.05]])
    assert hand_contact(distance).tolist() == [False, True, True, False]
    assert [JOINT_NAMES[hand] for hand in HANDS] == ["left_middle1", "right_middle1"]


@pytest.mark.parametrize("truth", [[1], [1, 0, 1], [[1, 1]], [1, float("nan")]])
def test_labels_are_of_the_same_frames(truth: list[float]) -> None:
    """One label more was an error of numpy, a single one a recall of 4."""
    with pytest.raises(InputError, match="truth: found"):
        metrics.contact_scores([1, 1], truth)
