"""Tables over time as few rows."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics.results.low_rank import MOST_FRAMES, low_rank


def waves(frames, count=400, rank=5):
    rng = np.random.default_rng(1)
    return rng.standard_normal((frames, rank)) @ rng.standard_normal((rank, count))


@pytest.mark.parametrize("frames", [7, 60, MOST_FRAMES + 150])
def test_the_product_is_the_table_with_no_more_rows_than_its_rank(frames):
    table = waves(frames)
    weights, rows, _ = low_rank(table, 1e-6, 64)
    assert len(rows) == 5
    assert np.abs(weights @ rows - table).max() < 1e-6
    np.testing.assert_allclose(np.abs(weights).max(axis=0), 1.0)


def test_the_tolerance_is_that_of_the_worst_number_and_saves_rows():
    rng = np.random.default_rng(2)
    table = waves(50) + 1e-3 * rng.standard_normal((50, 400))
    weights, rows, _ = low_rank(table, 0.02, 64)
    assert len(rows) == 5
    assert np.abs(weights @ rows - table).max() <= 0.02


def test_there_are_no_more_rows_than_asked():
    weights, rows, _ = low_rank(waves(50), 1e-9, 3)
    assert rows.shape == (3, 400)
    assert weights.shape == (50, 3)


def test_columns_beside_get_the_same_weights():
    table, beside = waves(40), 0.1 * waves(40, count=30)
    weights, rows, more = low_rank(table, 1e-9, 64, beside)
    assert more.shape == (len(rows), 30)
    assert np.abs(weights @ more - beside).max() < 1e-9


def test_a_table_of_zeros_needs_none():
    weights, rows, _ = low_rank(np.zeros((4, 9)), 1e-6, 8)
    assert weights.shape == (4, 0)
    assert rows.shape == (0, 9)


@pytest.mark.parametrize("frames", [50, 700])
def test_columns_beside_may_be_given_by_the_frame(frames):
    """The same numbers, and never all of them at once."""
    table = waves(frames)
    beside = np.cumsum(table[:, :5], axis=1)
    most = []

    def some(at):
        most.append(len(at))
        return beside[at]

    whole, by_frame = (low_rank(table, 1e-9, 64, given) for given in (beside, some))
    for one, other in zip(whole, by_frame, strict=True):
        assert np.array_equal(one, other)
    assert max(most) <= 300
