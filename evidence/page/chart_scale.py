"""Scales of the charts: what can be drawn, when a scale is logarithmic, where ticks are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, SymmetricalLogLocator

from evidence.page.wording import number, signed

#: A chart draws sizes up to this; a larger one comes from a computation that failed.
LARGEST = 1e30
#: A smaller size is drawn as zero.
_SMALLEST = 1e-30
#: A logarithmic scale needs positive values that span this many decades.
_DECADES = 3
#: A gap of this many decades between values: the smaller ones are rounding errors, no measures.
_ROUNDING = 6


def finite(value: Any) -> float | None:
    """A number that a chart can draw; None for anything else (texts and truth values too)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if not abs(value) <= LARGEST:
        return None
    return float(value) if abs(value) >= _SMALLEST else 0.0


def over_decades(values: Sequence[float]) -> bool:
    """Whether values are told apart better on a logarithmic scale than on a linear one.

    None is negative, the positive ones span three decades, they spread over decades at least as
    evenly as over the values themselves, and no gap between them is six decades wide.
    """
    some = sorted(v for v in values if v)
    if not some or some[0] < 0 or some[-1] < some[0] * 10.0**_DECADES:
        return False
    powers = [math.log10(v) for v in some]
    if any(b - a > _ROUNDING for a, b in pairwise(powers)):
        return False
    return _asymmetry(powers) <= _asymmetry(some)


def _asymmetry(some: Sequence[float]) -> float:
    """Distance of the median from the middle of sorted numbers, per their span."""
    middle = some[len(some) // 2] + some[(len(some) - 1) // 2]
    return abs(middle - some[0] - some[-1]) / (some[-1] - some[0])


def linear(axes: Axes, which: Literal["x", "y"], intervals: int) -> None:
    """Make a scale linear, with ticks at about so many intervals of 1, 2, 2.5 or 5."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(MaxNLocator(intervals, steps=[1, 2, 2.5, 5, 10]))
    axis.set_major_formatter(FuncFormatter(_label))


def logarithmic(
    axes: Axes, which: Literal["x", "y"], intervals: int, linear_to: float = 0.0
) -> None:
    """Make a scale logarithmic; `linear_to`: linear from zero to this value."""
    set_scale = axes.set_xscale if which == "x" else axes.set_yscale
    axis = axes.xaxis if which == "x" else axes.yaxis
    if linear_to:
        set_scale("symlog", linthresh=linear_to, linscale=1.0)
        locator = SymmetricalLogLocator(base=10, linthresh=linear_to)
        locator.set_params(numticks=intervals + 1)
        axis.set_major_locator(locator)
    else:
        set_scale("log")
        axis.set_major_locator(LogLocator(numticks=intervals + 1))
    axis.set_ticks([], minor=True)
    axis.set_major_formatter(FuncFormatter(_label))


def _label(value: float, _position: int | None = None) -> str:
    return signed(number(round(value, 12) if abs(value) > 1e-3 else value))
