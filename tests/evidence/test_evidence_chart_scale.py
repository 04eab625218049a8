"""Scales of the charts: which are logarithmic, and their ticks."""

from __future__ import annotations

import math

import pytest
from evidence_sample import plot, series

from evidence.page import charts
from evidence.page.chart_scale import finite, over_decades
from evidence.page.chart_svg import style


def ticks(values, kind="lines"):
    """Labels of a chart's value axis that are within its limits."""
    with style():
        one = plot("p", ("", ""), ("", ""), series("s", range(len(values)), values), kind=kind)
        figure = (charts._lines if kind == "lines" else charts._bars)(one, charts.WIDE)
        figure.draw_without_rendering()
        axis = figure.axes[0].yaxis if kind == "lines" else figure.axes[0].xaxis
        low, high = sorted(axis.get_view_interval())
        shown = zip(axis.get_majorticklocs(), axis.get_majorticklabels(), strict=True)
        slack = 1e-9 * (high - low)
        return [t.get_text() for at, t in shown if low - slack <= at <= high + slack]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([0, 12], ["0", "2.5", "5", "7.5", "10", "12.5"]),
        ([83.1, 145.5, 148.8], ["80", "100", "120", "140", "160"]),
        ([0.1, 0.9], ["0", "0.2", "0.4", "0.6", "0.8", "1"]),
        ([-3, 4], ["−4", "−2", "0", "2", "4"]),
        ([0, 12000], ["0", "2500", "5000", "7500", "10,000", "12,500"]),
        ([0, 6e-7], ["0", "2e-7", "4e-7", "6e-7"]),
        ([1, 10, 100, 1000, 10000], ["1", "10", "100", "1000", "10,000"]),
        ([1e-12, 1e-9, 1e-6], ["1e-12", "1e-10", "1e-8", "1e-6"]),
    ],
)
def test_ticks_are_round_numbers(values, expected):
    assert ticks(values) == expected


def test_a_logarithmic_scale_of_bars_is_linear_from_zero_to_its_first_power_of_ten():
    assert ticks([0.0, 0.01, 1.0, 100.0], "bars") == ["0", "0.01", "0.1", "1", "10", "100"]
    # Values more than six decades below the longest bar are on the linear part.
    assert ticks([1e-13, 1e-8, 1e-3, 1.0, 50.0], "bars")[:2] == ["0", "0.0001"]


def test_a_logarithmic_scale_is_for_what_spreads_over_decades():
    assert over_decades([1, 10, 100, 1000])
    assert not over_decades([1, 10, 100])  # two decades are too few
    assert not over_decades([k / 240 for k in range(1, 2881)])  # time is even on a linear scale
    assert not over_decades([0.002, *range(3, 20)])  # one small value does not decide the scale
    assert over_decades([0.1, 1000])
    assert not over_decades([1e-13, 2e-13, 30, 40, 50])  # rounding errors do not count
    assert over_decades([1e-13, 1e-9, 1e-5, 1e-1])  # a convergence counts
    assert not over_decades([-1, 1, 10, 100, 10000])
    assert over_decades([0, 1, 10, 100, 10000])
    assert not over_decades([0.0])
    assert not over_decades([])


@pytest.mark.parametrize(
    "value", [None, math.nan, math.inf, -math.inf, True, "3", [1], 10**400, 1e31, {}]
)
def test_what_cannot_be_drawn_is_skipped(value):
    assert finite(value) is None
    assert finite(1e-31) == 0.0
    assert ticks([value, 1.0, 3.0]) == ticks([1.0, 3.0])
