"""Axes of the report's plots: everything is on them, ticks are round and told apart."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from evidence.page.axis import axis, finite

numbers = st.floats(allow_nan=False, allow_infinity=False)


def labels(found):
    return [tick.label for tick in found.ticks]


@settings(deadline=None)
@example([0.0, 1.74e308], 9, True, False, None)
@example([1.7000000012e308], 2, True, False, None)
@example([-1.79e308, 1.79e308], 4, False, False, None)
@given(st.lists(numbers, max_size=8), st.integers(2, 9), st.booleans(), st.booleans(),
       st.sampled_from([None, True, False]))  # fmt: skip
def test_whatever_is_shown_is_on_the_axis(values, ticks, snug, from_zero, log):
    found = axis(values, ticks=ticks, snug=snug, from_zero=from_zero, log=log)
    assert all(-1e-9 <= found.at(v) <= 1 + 1e-9 for v in values)
    assert all(0 <= tick.at <= 1 for tick in found.ticks)
    assert all(a.at < b.at for a, b in pairwise(found.ticks))
    assert len(set(labels(found))) == len(found.ticks)
    assert 1 <= len(found.ticks) <= ticks + 3
    bigger = [found.at(v) for v in sorted(values)]
    assert all(a <= b for a, b in pairwise(bigger))


@settings(deadline=None)
@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=8))
def test_a_label_says_where_its_tick_is(values):
    for log in (False, True):
        found = axis(values, log=log)
        for tick in found.ticks:
            text = tick.label.replace(",", "").replace("−", "-")
            if not text.removeprefix("-").isascii():
                power = text[2:].translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
                text = f"1e{power}"
            if text != "0" or not log:
                assert found.at(float(text)) == pytest.approx(tick.at, abs=1e-6)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0, 12], ["0", "2.5", "5.0", "7.5", "10.0", "12.5"]),
        ([83.1, 145.5, 148.8], ["80", "100", "120", "140", "160"]),
        ([0.1, 0.9], ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        ([-3, 4], ["−4", "−2", "0", "2", "4"]),
        ([0, 12000], ["0", "2500", "5000", "7500", "10,000", "12,500"]),
        ([0, 6e-7], ["0", "2e-7", "4e-7", "6e-7"]),
        ([5], ["0", "1", "2", "3", "4", "5"]),
        ([0], ["−0.6", "−0.4", "−0.2", "0", "0.2", "0.4", "0.6"]),
        ([1e300, -1e300], ["−1e300", "−5e299", "0", "5e299", "1e300"]),
        ([], ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        ([1, 10, 100, 1000, 10000], ["1", "10", "100", "1000", "10,000"]),
        ([1e-12, 1e-9, 1e-6], ["10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶"]),
        ([0, 0.01, 1, 100], ["0", "0.01", "0.1", "1", "10", "100"]),
    ],
)
def test_ticks_stand_at_round_numbers(values, expected):
    assert labels(axis(values)) == expected


def test_decades_are_for_what_spreads_over_decades():
    assert axis([1, 10, 100, 1000]).log
    assert not axis([1, 10, 100]).log  # two decades are not three
    assert not axis([k / 240 for k in range(1, 2881)]).log  # time is even as it is
    assert not axis([0.002, *range(3, 20)]).log  # one that is small does not bend it for all
    assert axis([0.1, 1000]).log
    assert not axis([1e-13, 2e-13, 30, 40, 50]).log  # rounding is no size
    assert axis([1e-13, 1e-9, 1e-5, 1e-1]).log  # but what converges is one
    assert not axis([-1, 1, 10, 100, 10000]).log
    assert not axis([-1, 1, 10, 100, 10000], log=True).log
    assert axis([2, 3], log=True).log


def test_what_is_below_the_decades_shown_stands_at_the_foot():
    found = axis([1e-13, 1e-3, 1.0, 50.0], log=True, decades=6)
    assert found.zero
    assert found.at(1e-13) == found.at(0.0) == 0.0
    assert found.at(1e-3) > 0.1
    assert labels(found)[0] == "0"
    assert not axis([1e-3, 1.0], log=True).zero


def test_snug_axes_end_where_the_values_do():
    found = axis([0.0, 2.7], snug=True)
    assert (found.low, found.high) == (0.0, 2.7)
    assert labels(found) == ["0", "1", "2"]
    assert axis([1.0, 7.0], from_zero=True).low == 0.0
    near = axis([1 / 30, 3.9], snug=True)  # to the next tick, where it is near
    assert (near.low, near.high) == (0.0, 4.0)


@pytest.mark.parametrize(
    "value", [None, math.nan, math.inf, -math.inf, True, "3", [1], 10**400, {}]
)
def test_what_is_no_finite_number_is_not_drawn(value):
    assert finite(value) is None
    assert labels(axis([value, 1.0, 3.0])) == labels(axis([1.0, 3.0]))
