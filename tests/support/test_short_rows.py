"""Reductions along short rows are numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from support import short_rows as rows


@pytest.mark.parametrize("shape", [(0, 3), (1, 3), (7, 2), (50, 6, 3), (4, 5, 1)])
def test_along_any_axis_it_is_numpy(shape):
    x = np.random.default_rng(0).normal(size=shape)
    for axis in range(1, len(shape)):
        np.testing.assert_array_equal(rows.largest(x, axis), x.max(axis=axis))
        np.testing.assert_array_equal(rows.smallest(x, axis), x.min(axis=axis))
        np.testing.assert_array_equal(rows.every(x > 0.0, axis), (x > 0.0).all(axis=axis))
    np.testing.assert_allclose(rows.length(x), np.linalg.norm(x, axis=-1), rtol=1e-15)


def test_cross_products_are_numpys():
    a, b = np.random.default_rng(1).normal(size=(2, 40, 3))
    np.testing.assert_allclose(rows.cross(a, b), np.cross(a, b), rtol=0, atol=1e-15)


def test_what_is_no_number_is_not_clear():
    """A pose that is not finite is on no outer side of anything."""
    assert not rows.every(np.array([[1.0, np.nan, 1.0]]) > 0.0)[0]
