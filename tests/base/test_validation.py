"""Checks of single values: accepted values, refused values and messages."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from halfphysics.base.validation import file_path, frame_rate, number, quaternion, shown, vector
from halfphysics.errors import InputError
from halfphysics.settings import Settings


def test_numbers_of_any_kind() -> None:
    for value in (3, 3.0, np.float32(3), np.int64(3), np.array(3.0), Decimal(3)):
        assert number(value, "x", above=0.0) == 3.0
    assert number(0, "x", least=0.0) == 0.0
    assert number(1, "x", least=0.0, most=1.0) == 1.0


@pytest.mark.parametrize(
    "value",
    [
        None, "3", True, np.True_, 1j, [3.0], np.nan, np.inf, 10**400, 0.0, -1,
        Decimal("NaN"), Decimal("sNaN"), Decimal("Infinity"),
    ],
)  # fmt: skip
def test_not_a_positive_number(value: Any) -> None:
    with pytest.raises(InputError, match=r"ball: mass: expected a number above 0 \[kg\], found"):
        number(value, "ball: mass", above=0.0, unit="kg")


@pytest.mark.parametrize("value", [None, "abc", 3.0, (1, 2), (1, 2, np.inf), [[1], [2, 3]], "123"])
def test_not_a_vector(value: Any) -> None:
    with pytest.raises(InputError, match="v: expected 3 finite numbers, found"):
        vector(value, "v")
    assert not vector([1, 2, 3], "v").flags.writeable


@given(st.lists(st.floats(-1e200, 1e200), min_size=4, max_size=4))
def test_quaternions_become_unit_once(value: list[float]) -> None:
    if not any(value):
        with pytest.raises(InputError, match="zero length"):
            quaternion(value, "q")
        return
    unit = quaternion(value, "q")
    assert np.linalg.norm(unit) == pytest.approx(1.0, abs=1e-15)
    largest = int(np.argmax(np.abs(value)))
    np.testing.assert_allclose(
        unit / unit[largest], np.divide(value, value[largest]), rtol=1e-14, atol=1e-300
    )
    np.testing.assert_array_equal(quaternion(unit, "q"), unit)


def test_settings_are_finite() -> None:
    for value in (np.nan, np.inf, -np.inf, 10**400):
        with pytest.raises(InputError, match=r"Settings\.stiffness is .* expected a finite number"):
            Settings(stiffness=value)


def test_long_values_are_cut() -> None:
    assert len(shown(list(range(1000)))) == 80


def test_paths() -> None:
    assert file_path("a/b.npz") == file_path(Path("a/b.npz")) == Path("a/b.npz")
    for value in (None, 3, b"a", ["a"], "a\0b"):
        with pytest.raises(InputError, match=r"path: expected the path of a file.*found "):
            file_path(value)


def test_frame_rates() -> None:
    for value in (np.float32(30), np.array(30), Decimal("30")):
        assert frame_rate(value) == 30.0
    assert frame_rate(60.0, most=60.0) == 60.0
    with pytest.raises(InputError, match=r"^fps: found 61, expected at most 60 frames per second"):
        frame_rate(61.0, most=60.0)
    for value in (None, "fast", "30", b"30", True, [30.0], 0, -1.0, np.inf, np.nan, 10**400):
        with pytest.raises(InputError, match=r"fps: found .*positive number, such as 60\.0"):
            frame_rate(value, "60.0")
